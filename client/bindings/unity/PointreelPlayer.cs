// Plays a reel or a live stream in Unity 2021.2 or newer: a thread of its own reads frames into
// arrays, and Update copies the newest into GraphicsBuffers and draws a square for each point.
//
// Add it to an object, and give it a material with the shader Pointreel/Points.
using System;
using System.Threading;
using UnityEngine;

namespace Pointreel
{
    public class PointreelPlayer : MonoBehaviour
    {
        [Tooltip("A folder, http://HOST/REEL, or ws://HOST/live/NAME")]
        public string where = "http://127.0.0.1:8090/REEL";
        public Material material;
        [Tooltip("The edge of a point, in the units of the source")]
        public float pointSize = 0.006f;

        /// <summary>A frame as the graphics card takes it.</summary>
        class Points
        {
            public int Count;
            public float[] Positions;
            public uint[] Colors;
            public Vector3 Origin;
        }

        readonly object gate = new object();
        Points ready; // from the thread, guarded by the gate
        Thread thread;
        Canceller canceller;
        GraphicsBuffer positions, colors;
        int count;
        Vector3 origin;

        void OnEnable()
        {
            canceller = new Canceller();
            thread = new Thread(Read);
            thread.IsBackground = true;
            thread.Start();
        }

        void OnDisable()
        {
            canceller.Cancel();
            thread.Join();
            canceller.Dispose();
            Release();
        }

        // --- On the thread that reads ---------------------------------------------------------------

        void Read()
        {
            try
            {
                if (where.StartsWith("ws://") || where.StartsWith("wss://"))
                    ReadLive();
                else
                    ReadReel();
            }
            catch (Exception exception)
            {
                PointreelException known = exception as PointreelException;
                if (known == null || known.Status != Status.Cancelled)
                    Debug.LogError("Pointreel: " + exception.Message);
            }
        }

        void ReadLive()
        {
            using (Live live = new Live(where, canceller))
                for (;;)
                    using (Frame frame = live.Next(1000))
                        if (frame != null)
                            Give(PointsOf(frame));
        }

        void ReadReel()
        {
            using (Reel reel = new Reel(where, canceller))
            {
                if (reel.Frames == 0)
                    throw new Exception(where + ": the reel has no frames");
                System.Diagnostics.Stopwatch clock = System.Diagnostics.Stopwatch.StartNew();
                double duration = Math.Max(1e-3, 1e-6 * reel.Info.DurationUs);
                for (long shown = 0;; ++shown)
                {
                    int index = (int)(shown % reel.Frames);
                    double due = shown / reel.Frames * duration + reel.Time(index);
                    if (clock.Elapsed.TotalSeconds > due + 0.5)
                        continue; // too late: the next one
                    Points points;
                    using (Frame frame = reel.Read(index))
                        points = PointsOf(frame);
                    while (clock.Elapsed.TotalSeconds < due)
                        Thread.Sleep(1);
                    Give(points);
                }
            }
        }

        static Points PointsOf(Frame frame)
        {
            Points points = new Points();
            points.Count = frame.Points;
            points.Positions = frame.Positions();
            points.Colors = new uint[points.Count];
            byte[] rgb = frame.Colors();
            for (int i = 0; i < points.Count; ++i)
                points.Colors[i] = rgb == null ? 0xffc0c0c0u
                    : 0xff000000u | rgb[3 * i] | (uint)rgb[3 * i + 1] << 8 | (uint)rgb[3 * i + 2] << 16;
            points.Origin = new Vector3((float)frame.Info.OriginX, (float)frame.Info.OriginY, (float)frame.Info.OriginZ);
            return points;
        }

        void Give(Points points)
        {
            lock (gate)
                ready = points;
        }

        // --- On Unity's thread ----------------------------------------------------------------------

        void Update()
        {
            Points points;
            lock (gate)
            {
                points = ready;
                ready = null;
            }
            if (points != null)
                Upload(points);
            if (count == 0 || material == null)
                return;
            RenderParams parameters = new RenderParams(material);
            parameters.worldBounds = new Bounds(transform.position, 1e4f * Vector3.one);
            parameters.matProps = new MaterialPropertyBlock();
            parameters.matProps.SetBuffer("_Positions", positions);
            parameters.matProps.SetBuffer("_Colors", colors);
            parameters.matProps.SetVector("_Origin", new Vector4(origin.x, origin.y, origin.z, pointSize));
            parameters.matProps.SetMatrix("_ToWorld", transform.localToWorldMatrix);
            Graphics.RenderPrimitives(parameters, MeshTopology.Triangles, 6, count);
        }

        void Upload(Points points)
        {
            if (positions == null || positions.count < points.Count)
            {
                Release();
                int room = Math.Max(1, points.Count + points.Count / 4);
                positions = new GraphicsBuffer(GraphicsBuffer.Target.Structured, room, 12);
                colors = new GraphicsBuffer(GraphicsBuffer.Target.Structured, room, 4);
            }
            positions.SetData(points.Positions, 0, 0, 3 * points.Count);
            colors.SetData(points.Colors, 0, 0, points.Count);
            count = points.Count;
            origin = points.Origin;
        }

        void Release()
        {
            if (positions != null)
                positions.Release();
            if (colors != null)
                colors.Release();
            positions = colors = null;
            count = 0;
        }
    }
}
