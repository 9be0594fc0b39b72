// Pointreel for C#: declarations of libpointreel, and classes that own its handles. pointreel.h
// explains the functions, their errors, and what threads may do. Goes into a Unity project as it is,
// with libpointreel.so in Assets/Plugins/x86_64, and works with .NET and Mono, too.
using System;
using System.Runtime.InteropServices;
using System.Text;

namespace Pointreel
{
    public enum Status
    {
        Ok = 0,
        Invalid = 1,
        Unsupported = 2,
        Limit = 3,
        Argument = 4,
        NotFound = 5,
        Io = 6,
        Cancelled = 7,
        Timeout = 8,
        Internal = 9,
        Refused = 10
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct ReadOptions
    {
        public UIntPtr StructSize;
        public uint Layers;
        public ulong MaxMemory;
        public IntPtr Canceller;
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct FrameInfo
    {
        public UIntPtr StructSize;
        public ulong Points;
        public uint Index;
        public uint Layers;
        public ulong TimeUs;
        public double OriginX, OriginY, OriginZ;
        public int HasColors, HasNormals;
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct OpenOptions
    {
        public UIntPtr StructSize;
        public double Fps;
        public IntPtr Token, CaFile; // UTF-8, with a 0 at the end
        public int FollowRedirects;
        public IntPtr Canceller;
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct ReelInfo
    {
        public UIntPtr StructSize;
        public uint Frames;
        public uint Layers;
        public double Fps;
        public ulong DurationUs;
        public double MinX, MinY, MinZ, MaxX, MaxY, MaxZ;
        public int HasColors, HasNormals;
        public byte Up; // 'x', 'y' or 'z', or 'X', 'Y' or 'Z' if that axis points down
    }

    /// <summary>The functions of libpointreel that a player needs.</summary>
    public static class Native
    {
        const string Library = "pointreel";

        [DllImport(Library)] public static extern IntPtr pointreel_version();
        [DllImport(Library)] public static extern IntPtr pointreel_error_message();

        [DllImport(Library)] public static extern Status pointreel_canceller_create(out IntPtr canceller);
        [DllImport(Library)] public static extern Status pointreel_cancel(IntPtr canceller);
        [DllImport(Library)] public static extern void pointreel_canceller_close(IntPtr canceller);

        [DllImport(Library)] public static extern Status pointreel_reel_open(byte[] where, ref OpenOptions options, out IntPtr reel);
        [DllImport(Library)] public static extern Status pointreel_reel_get_info(IntPtr reel, ref ReelInfo info);
        [DllImport(Library)] public static extern Status pointreel_reel_get_metadata(IntPtr reel, byte[] text, UIntPtr capacity, out UIntPtr length);
        [DllImport(Library)] public static extern Status pointreel_reel_get_frame_time(IntPtr reel, uint index, out ulong timeUs);
        [DllImport(Library)] public static extern Status pointreel_reel_get_trouble(IntPtr reel, byte[] text, UIntPtr capacity, out UIntPtr length);
        [DllImport(Library)] public static extern Status pointreel_reel_read(IntPtr reel, uint index, ref ReadOptions options, out IntPtr frame);
        [DllImport(Library)] public static extern void pointreel_reel_close(IntPtr reel);

        [DllImport(Library)] public static extern Status pointreel_live_open(byte[] url, ref OpenOptions options, out IntPtr live);
        [DllImport(Library)] public static extern Status pointreel_live_next(IntPtr live, uint timeoutMs, ref ReadOptions options, out IntPtr frame);
        [DllImport(Library)] public static extern Status pointreel_live_get_trouble(IntPtr live, byte[] text, UIntPtr capacity, out UIntPtr length);
        [DllImport(Library)] public static extern void pointreel_live_close(IntPtr live);

        [DllImport(Library)] public static extern Status pointreel_frame_get_info(IntPtr frame, ref FrameInfo info);
        [DllImport(Library)] public static extern Status pointreel_frame_get_positions(IntPtr frame, [Out] float[] values, UIntPtr capacity, out UIntPtr count);
        [DllImport(Library)] public static extern Status pointreel_frame_get_world_positions(IntPtr frame, [Out] double[] values, UIntPtr capacity, out UIntPtr count);
        [DllImport(Library)] public static extern Status pointreel_frame_get_colors_8(IntPtr frame, [Out] byte[] values, UIntPtr capacity, out UIntPtr count);
        [DllImport(Library)] public static extern Status pointreel_frame_get_normals(IntPtr frame, [Out] float[] values, UIntPtr capacity, out UIntPtr count);
        [DllImport(Library)] public static extern IntPtr pointreel_frame_positions(IntPtr frame);
        [DllImport(Library)] public static extern IntPtr pointreel_frame_colors(IntPtr frame);
        [DllImport(Library)] public static extern IntPtr pointreel_frame_normals(IntPtr frame);
        [DllImport(Library)] public static extern void pointreel_frame_close(IntPtr frame);

        [DllImport(Library)] public static extern Status pointreel_decode(byte[] data, UIntPtr size, ref ReadOptions options, out IntPtr frame);
    }

    public class PointreelException : Exception
    {
        public readonly Status Status;

        PointreelException(Status status, string message) : base(message) { Status = status; }

        /// <summary>Throws what the last call of this thread says, unless its status is Ok.</summary>
        public static void Check(Status status)
        {
            if (status != Status.Ok)
                throw new PointreelException(status, Text.Of(Native.pointreel_error_message()));
        }
    }

    static class Text
    {
        /// <summary>`name` is that of the argument.</summary>
        public static byte[] Utf8(string text, string name)
        {
            if (text == null)
                throw new ArgumentNullException(name);
            if (text.IndexOf('\0') >= 0)
                throw new ArgumentException("must not contain a null character", name);
            return Encoding.UTF8.GetBytes(text + "\0");
        }

        public static string Of(IntPtr text)
        {
            int length = 0;
            while (Marshal.ReadByte(text, length) != 0)
                ++length;
            byte[] bytes = new byte[length];
            Marshal.Copy(text, bytes, 0, length);
            return Encoding.UTF8.GetString(bytes);
        }
    }

    /// <summary>Stops what takes long, from any thread.</summary>
    public sealed class Canceller : IDisposable
    {
        internal readonly IntPtr Handle;

        public Canceller() { PointreelException.Check(Native.pointreel_canceller_create(out Handle)); }
        public void Cancel() { PointreelException.Check(Native.pointreel_cancel(Handle)); }
        public void Dispose() { Native.pointreel_canceller_close(Handle); GC.SuppressFinalize(this); }
        ~Canceller() { Native.pointreel_canceller_close(Handle); }

        internal static IntPtr HandleOf(Canceller canceller)
        {
            return canceller == null ? IntPtr.Zero : canceller.Handle;
        }
    }

    /// <summary>A decoded frame.</summary>
    public sealed class Frame : IDisposable
    {
        readonly IntPtr handle;
        public readonly FrameInfo Info;

        internal Frame(IntPtr handle)
        {
            this.handle = handle;
            Info.StructSize = (UIntPtr)(uint)Marshal.SizeOf(typeof(FrameInfo));
            PointreelException.Check(Native.pointreel_frame_get_info(handle, ref Info));
        }

        public int Points { get { return (int)Info.Points; } }

        /// <summary>x, y and z of each point, relative to the origin in Info. An array that is given
        /// is used if it has room.</summary>
        public float[] Positions(float[] room = null)
        {
            UIntPtr count;
            if (room == null || room.Length < 3 * Points)
                room = new float[3 * Points];
            PointreelException.Check(Native.pointreel_frame_get_positions(handle, room, (UIntPtr)(uint)(room.Length / 3), out count));
            return room;
        }

        /// <summary>Red, green and blue of each point; null without colours.</summary>
        public byte[] Colors(byte[] room = null)
        {
            if (Info.HasColors == 0)
                return null;
            UIntPtr count;
            if (room == null || room.Length < 3 * Points)
                room = new byte[3 * Points];
            PointreelException.Check(Native.pointreel_frame_get_colors_8(handle, room, (UIntPtr)(uint)(room.Length / 3), out count));
            return room;
        }

        /// <summary>The frame's own array of positions, until the frame is disposed.</summary>
        public IntPtr PositionsInPlace { get { return Native.pointreel_frame_positions(handle); } }

        public void Dispose() { Native.pointreel_frame_close(handle); GC.SuppressFinalize(this); }
        ~Frame() { Native.pointreel_frame_close(handle); }

        /// <summary>Decodes what pointreel_encode made, or a PLY or Draco file.</summary>
        public static Frame Decode(byte[] data)
        {
            if (data == null)
                throw new ArgumentNullException("data");
            IntPtr frame;
            ReadOptions options = Reel.Reading(null, 0);
            PointreelException.Check(Native.pointreel_decode(data, (UIntPtr)(uint)data.Length, ref options, out frame));
            return new Frame(frame);
        }
    }

    /// <summary>A package or a folder of files, or the address of a package.</summary>
    public sealed class Reel : IDisposable
    {
        readonly IntPtr handle;
        readonly Canceller canceller;
        public readonly ReelInfo Info;

        public Reel(string where, Canceller canceller = null)
        {
            this.canceller = canceller;
            OpenOptions options = Opening(canceller);
            PointreelException.Check(Native.pointreel_reel_open(Text.Utf8(where, "where"), ref options, out handle));
            Info.StructSize = (UIntPtr)(uint)Marshal.SizeOf(typeof(ReelInfo));
            PointreelException.Check(Native.pointreel_reel_get_info(handle, ref Info));
        }

        public int Frames { get { return (int)Info.Frames; } }

        /// <summary>Seconds from the reel's start.</summary>
        public double Time(int index)
        {
            ulong us;
            PointreelException.Check(Native.pointreel_reel_get_frame_time(handle, (uint)index, out us));
            return 1e-6 * us;
        }

        /// <summary>Fetches and decodes a frame, of its first layers if `layers` is not 0.</summary>
        public Frame Read(int index, int layers = 0)
        {
            IntPtr frame;
            ReadOptions options = Reading(canceller, layers);
            PointreelException.Check(Native.pointreel_reel_read(handle, (uint)index, ref options, out frame));
            return new Frame(frame);
        }

        public void Dispose() { Native.pointreel_reel_close(handle); GC.SuppressFinalize(this); }
        ~Reel() { Native.pointreel_reel_close(handle); }

        internal static OpenOptions Opening(Canceller canceller)
        {
            OpenOptions options = new OpenOptions();
            options.StructSize = (UIntPtr)(uint)Marshal.SizeOf(typeof(OpenOptions));
            options.Canceller = Canceller.HandleOf(canceller);
            return options;
        }

        internal static ReadOptions Reading(Canceller canceller, int layers)
        {
            ReadOptions options = new ReadOptions();
            options.StructSize = (UIntPtr)(uint)Marshal.SizeOf(typeof(ReadOptions));
            options.Layers = (uint)layers;
            options.Canceller = Canceller.HandleOf(canceller);
            return options;
        }
    }

    /// <summary>A live stream: ws://HOST/live/NAME.</summary>
    public sealed class Live : IDisposable
    {
        readonly IntPtr handle;
        readonly Canceller canceller;

        public Live(string url, Canceller canceller = null)
        {
            this.canceller = canceller;
            OpenOptions options = Reel.Opening(canceller);
            PointreelException.Check(Native.pointreel_live_open(Text.Utf8(url, "url"), ref options, out handle));
        }

        /// <summary>A frame newer than the last one; null if none has come by then.</summary>
        public Frame Next(uint timeoutMs)
        {
            IntPtr frame;
            ReadOptions options = Reel.Reading(canceller, 0);
            Status status = Native.pointreel_live_next(handle, timeoutMs, ref options, out frame);
            if (status == Status.Timeout)
                return null;
            PointreelException.Check(status);
            return new Frame(frame);
        }

        public void Dispose() { Native.pointreel_live_close(handle); GC.SuppressFinalize(this); }
        ~Live() { Native.pointreel_live_close(handle); }
    }
}
