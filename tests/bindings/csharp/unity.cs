// What the example for Unity uses of UnityEngine, for the compiler alone: Unity itself is not needed
// to find mistakes in it.
using System;

namespace UnityEngine
{
    public class MonoBehaviour { public Transform transform; }
    public class Transform { public Vector3 position; public Matrix4x4 localToWorldMatrix; }
    public struct Vector3
    {
        public float x, y, z;
        public static Vector3 one;
        public Vector3(float x, float y, float z) { this.x = x; this.y = y; this.z = z; }
        public static Vector3 operator *(float scale, Vector3 v) { return v; }
    }
    public struct Vector4 { public Vector4(float x, float y, float z, float w) { } }
    public struct Matrix4x4 { }
    public struct Bounds { public Bounds(Vector3 center, Vector3 size) { } }
    public class Material { }
    public class TooltipAttribute : Attribute { public TooltipAttribute(string text) { } }
    public static class Debug { public static void LogError(object message) { } }
    public enum MeshTopology { Triangles }
    public class GraphicsBuffer
    {
        public enum Target { Structured }
        public GraphicsBuffer(Target target, int count, int stride) { }
        public int count;
        public void SetData(Array data, int from, int to, int count) { }
        public void Release() { }
    }
    public class MaterialPropertyBlock
    {
        public void SetBuffer(string name, GraphicsBuffer buffer) { }
        public void SetVector(string name, Vector4 value) { }
        public void SetMatrix(string name, Matrix4x4 value) { }
    }
    public struct RenderParams
    {
        public RenderParams(Material material) { worldBounds = new Bounds(); matProps = null; }
        public Bounds worldBounds { get; set; }
        public MaterialPropertyBlock matProps { get; set; }
    }
    public static class Graphics
    {
        public static void RenderPrimitives(RenderParams parameters, MeshTopology topology, int vertices, int instances) { }
    }
}
