// A square for each point, which faces the eye.
Shader "Pointreel/Points"
{
    SubShader
    {
        Tags { "RenderType" = "Opaque" }
        Cull Off
        Pass
        {
            HLSLPROGRAM
            #pragma target 4.5
            #pragma vertex vertex
            #pragma fragment fragment
            #include "UnityCG.cginc"

            StructuredBuffer<float3> _Positions;
            StructuredBuffer<uint> _Colors;
            float4 _Origin; // and the edge of a point
            float4x4 _ToWorld;

            struct Varyings
            {
                float4 position : SV_POSITION;
                float3 color : COLOR;
            };

            Varyings vertex(uint corner : SV_VertexID, uint point_index : SV_InstanceID)
            {
                // Two triangles: 0 1 2 and 2 1 3.
                uint index = corner < 3 ? corner : corner == 3 ? 2 : corner == 4 ? 1 : 3;
                float2 offset = float2(index & 1, index >> 1) - 0.5;
                // Unity's z points the other way.
                float3 local = (_Positions[point_index] + _Origin.xyz) * float3(1, 1, -1);
                float3 world = mul(_ToWorld, float4(local, 1)).xyz;
                float scale = length(mul((float3x3)_ToWorld, float3(1, 0, 0)));
                float4 eye = mul(UNITY_MATRIX_V, float4(world, 1));
                eye.xy += offset * _Origin.w * scale;
                Varyings result;
                result.position = mul(UNITY_MATRIX_P, eye);
                uint color = _Colors[point_index];
                float3 srgb = float3(color & 255, color >> 8 & 255, color >> 16 & 255) / 255.0;
                #ifdef UNITY_COLORSPACE_GAMMA
                result.color = srgb;
                #else
                result.color = GammaToLinearSpace(srgb);
                #endif
                return result;
            }

            float4 fragment(Varyings varyings) : SV_Target { return float4(varyings.color, 1); }
            ENDHLSL
        }
    }
}
