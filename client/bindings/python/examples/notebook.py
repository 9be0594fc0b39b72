# %% [markdown]
# # Point clouds that move, in Python
#
# Cells begin with `# %%`: Jupyter (by Jupytext), VS Code and Spyder run them one by one. Plain
# Python runs all of them: `python3 notebook.py [REEL]`. Without a REEL, the folder or address of a
# package, it makes one of arrays.

# %%
import pathlib
import sys
import tempfile

import numpy as np

import pointreel

folder = pathlib.Path(tempfile.mkdtemp())

# %% [markdown]
# ## From arrays to a package
#
# Each frame is positions, and colours and normals if there are any. A generator will do, so that
# the frames need not fit into memory. What Open3D calls a PointCloud can be given as it is.


# %%
def waves(frames=30, side=300):
    """A sheet with waves that run outwards."""
    x, z = np.meshgrid(np.linspace(-1, 1, side), np.linspace(-1, 1, side))
    distance = np.hypot(x, z)
    for i in range(frames):
        phase = 12 * distance - 2 * np.pi * i / frames
        height, slope = 0.1 * np.cos(phase), -1.2 * np.sin(phase)
        safe = np.maximum(distance, 1e-9)
        normals = np.stack([-slope * x / safe, np.ones_like(x), -slope * z / safe], axis=-1)
        positions = np.stack([x, height, z], axis=-1)
        colors = np.stack([0.5 + 4 * height, 0.4 + 0 * x, 0.7 - 3 * height], axis=-1)
        yield positions.reshape(-1, 3), colors.reshape(-1, 3), normals.reshape(-1, 3)


where = sys.argv[1] if len(sys.argv) > 1 else folder / "waves.reel"
if len(sys.argv) < 2:
    print(pointreel.pack(waves(), where, fps=30, name="waves"), "frames in", where)

# %% [markdown]
# ## Reading
#
# A reel is a sequence. `positions`, `colors` and `normals` are the decoder's memory itself; `world`
# adds the origin, in double precision.

# %%
reel = pointreel.open(where)
print(reel, "of", reel.duration, "s, bounds", reel.bounds.tolist())
frame = reel[len(reel) // 2]
print(frame, "at", frame.time, "s;", frame.positions.dtype, frame.positions.shape)

# %% [markdown]
# Iteration decodes the next frames while this one is worked with.

# %%
for frame in reel[::5]:
    low, high = np.percentile(frame.world[:, 1], [1, 99])
    print(f"{frame.time:6.2f} s  {len(frame):7} points, heights {low:+.2f} to {high:+.2f}")

# %% [markdown]
# The first layers of octrees are coarse, and take a fraction of the bytes.

# %%
for layers in range(1, reel.layers + 1):
    print(layers, "layers:", len(reel.read(0, layers)), "points")

# %% [markdown]
# ## Pictures
#
# Drawn as the player draws, by the processor: no display is needed.

# %%
picture = pointreel.render(reel[0], size=(960, 540), view=(30, 25), up=reel.up)
with open(folder / "picture.ppm", "wb") as out:
    out.write(b"P6 %d %d 255\n" % (picture.shape[1], picture.shape[0]) + picture.tobytes())
print("picture:", folder / "picture.ppm")

# %% [markdown]
# ## Single frames as bytes
#
# For a database, a message or a file of your own.

# %%
data = pointreel.encode(*next(waves()))
back = pointreel.decode(data)
print(len(data), "bytes for", len(back), "points:", f"{8 * len(data) / len(back):.1f} bits each")

# %% [markdown]
# ## Live streams
#
#     for frame in pointreel.live("ws://HOST:8090/live/alice"):
#         ...
