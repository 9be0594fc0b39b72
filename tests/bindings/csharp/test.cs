// Uses the library from C#: reads the reel that the test of the C interface wrote.
//
//   test.exe REEL
using System;
using System.Threading;
using Pointreel;

static class Test
{
    static void Expect(bool condition, string what)
    {
        if (!condition)
            throw new Exception("not so: " + what);
    }

    static Status StatusOf(Action work)
    {
        try
        {
            work();
            return Status.Ok;
        }
        catch (PointreelException exception)
        {
            Expect(exception.Message.Length > 0, "there is a message");
            return exception.Status;
        }
    }

    static bool Refuses<E>(Action work) where E : Exception
    {
        try
        {
            work();
            return false;
        }
        catch (E)
        {
            return true;
        }
    }

    static int Main(string[] arguments)
    {
        using (Reel reel = new Reel(arguments[0]))
        {
            Expect(reel.Frames == 7 && reel.Info.Fps == 25.0 && reel.Info.Up == (byte)'Z', "the reel's info");
            Expect(reel.Info.MinX == 1000.0 && reel.Info.MaxX == 1015.0, "the reel's bounds");
            for (int i = 0; i < reel.Frames; ++i)
                using (Frame frame = reel.Read(i))
                {
                    Expect(frame.Points == 1000 && frame.Info.Index == i, "the frame's info");
                    Expect(frame.Info.TimeUs == Math.Round(1e6 * reel.Time(i)), "the frame's time");
                    float[] positions = frame.Positions();
                    byte[] colors = frame.Colors();
                    Expect(positions.Length == 3000 && colors.Length == 3000, "lengths");
                    for (int p = 0; p < 1000; ++p)
                    {
                        double x = positions[3 * p] + frame.Info.OriginX - 1000.0 - i;
                        double y = positions[3 * p + 1] + frame.Info.OriginY;
                        double z = positions[3 * p + 2] + frame.Info.OriginZ;
                        int source = (int)Math.Round(x + 10 * y + 100 * z);
                        Expect(colors[3 * p] == (source + i) % 256, "the colour of a point");
                    }
                    Expect(frame.PositionsInPlace != IntPtr.Zero, "positions in place");
                }
            Expect(StatusOf(() => reel.Read(7)) == Status.Argument, "there is no frame 7");
            reel.Dispose();
            Expect(StatusOf(() => reel.Read(0)) == Status.Argument, "a closed reel");
        }
        Expect(StatusOf(() => new Reel("/nowhere/ü")) == Status.NotFound, "no such reel");
        Expect(StatusOf(() => Frame.Decode(new byte[100])) == Status.Invalid, "bytes that are no frame");
        Expect(Refuses<ArgumentException>(() => new Reel("a\0b")), "a name with a null character");
        Expect(Refuses<ArgumentNullException>(() => new Reel(null)), "no name");
        Expect(Refuses<ArgumentNullException>(() => Frame.Decode(null)), "no bytes");
        using (Canceller canceller = new Canceller())
        using (Live live = new Live("ws://127.0.0.1:9/live/nobody", canceller))
        {
            Expect(live.Next(1) == null, "nothing comes");
            Thread thread = new Thread(() => { Thread.Sleep(50); canceller.Cancel(); });
            thread.Start();
            Expect(StatusOf(() => live.Next(3600000)) == Status.Cancelled, "it was cancelled");
            thread.Join();
        }
        Console.WriteLine("C# reads what C wrote");
        return 0;
    }
}
