#pragma once

#include <cstdint>

/// What the WebAssembly module exports: the decoder, the preparation of frames, and the decisions
/// of the player, which the page takes by the same functions as the desktop player.
///
/// Rules of all functions:
///
/// - The module imports nothing and has no threads. `_initialize` is called once, before anything
///   else. Several instances of the module know nothing of each other.
/// - Numbers are passed as they are: a pointer is a number, the offset of a byte in the exported
///   memory. Structures that both sides read hold numbers of one type only and no gaps, so that one
///   typed array over the memory reads each: Float64Array unless it says otherwise. Booleans and
///   values of an enum are 0, 1, 2, ... there, and so are all other whole numbers.
/// - Calls may make the memory grow, which detaches every ArrayBuffer of it. So views of the memory
///   are made anew after each call.
/// - What the caller passes by pointer stays the caller's, and is not looked at after the call.
///   What a function returns by pointer stays the module's, and is valid until the next call of
///   the same function, unless it says otherwise. Handles are made by a `_new` and end by the
///   `_free` of the same name; freeing 0 does nothing.
/// - Texts that go in are UTF-8 with their size in bytes. Texts that come out end with a 0 byte.
/// - A function with an error as result returns 0 if all went well. Otherwise it returns the number
///   of a PrError, and pr_error_text says why: one line for a person. Functions that return a
///   pointer return 0 on failure, and pr_error_code tells the number.
/// - Trust: all bytes and texts may be hostile, and are checked as on the desktop. Numbers,
///   pointers and handles are the page's own, and are not checked. Memory that a frame needs is
///   bounded beforehand (PrPrepare::max_memory). If there is not enough all the same, or if there
///   is a fault in the module, the call traps; the instance must then be thrown away.
/// - The module has no clock. Where time matters, the caller passes it: `now_us` in microseconds
///   from any start, which must not decrease.

#if defined(__wasm__)
#define PR_EXPORT(result, name) \
  extern "C" __attribute__((export_name(#name), visibility("default"))) result name
#else
#define PR_EXPORT(result, name) extern "C" result name
#endif

// ---- Memory and errors ----------------------------------------------------------------------

/// ErrorCode (pointreel/error.h), counted from 1; 0: none.
enum PrError : std::int32_t {
  PR_OK = 0,
  PR_INVALID = 1,
  PR_UNSUPPORTED = 2,
  PR_LIMIT = 3,
  PR_ARGUMENT = 4,
  PR_NOT_FOUND = 5,
  PR_IO = 6,
  PR_CANCELLED = 7,
  PR_REFUSED = 8,
};

/// Memory for the caller's own use, aligned to 16 bytes. 0 if there is not enough.
PR_EXPORT(void*, pr_alloc)(std::uint32_t bytes);
PR_EXPORT(void, pr_free)(void* memory);
/// The bytes that are allocated at the moment, by the caller and by the module.
PR_EXPORT(double, pr_memory_in_use)();

/// Of the last function that failed.
PR_EXPORT(const char*, pr_error_text)();
PR_EXPORT(PrError, pr_error_code)();

// ---- Context tables -------------------------------------------------------------------------

/// The tables of the format, which frames with the entropy "context" need: the file tables/1.zst,
/// which travels beside the module. Once, before the first frame is prepared and before
/// pr_tables_new.
PR_EXPORT(PrError, pr_load_tables)(const std::uint8_t* bytes, std::uint32_t size);

/// A reel's own tables, from the file that PrReelInfo::tables_bytes tells of. The checksum is that
/// of the manifest (PR_TEXT_TABLES_CHECKSUM); the bytes must have it.
struct PrTables;
PR_EXPORT(PrTables*, pr_tables_new)
(const std::uint8_t* bytes, std::uint32_t size, const char* checksum, std::uint32_t checksum_size);
PR_EXPORT(void, pr_tables_free)(PrTables* tables);

// ---- Reels ----------------------------------------------------------------------------------

/// A manifest, checked. A reel that comes live (pr_live_reel) has everything but frames.
struct PrReel;

struct PrReelInfo {
  double frames;
  double duration_us;  ///< of one pass; > 0 if there are frames
  double fps;          ///< nominal
  double codec;        ///< 1 octree, 2 Draco, 3 video
  double layers;       ///< at least 1
  double segments;
  double depth_min, depth_max;
  double up;  ///< as in PrCamera
  double colors, normals;
  double partial;        ///< some frames may have fewer layers than others
  double bounds_min[3];  ///< of all frames, in the world; min > max: empty
  double bounds_max[3];
  double max_error;     ///< how far points may be from where they were; -1: nobody says
  double tables_bytes;  ///< size of the file of the reel's own tables; 0: it has none
  // For a reel that is still being captured:
  double live;               ///< more frames may come; if not, what follows is 0
  double live_first_frame;   ///< how many frames of the session came before the first of the reel
  double live_start_us;      ///< Unix time of the reel's time 0
  double live_ended;         ///< no publisher is connected at the moment
  double audio_bytes;        ///< size of the file of sound; 0: it has none
  double scalars;            ///< scalar fields that any frame has
  double group_frames;       ///< of video: PrGroup; otherwise 0
  double normals_estimated;  ///< normals may point to either side
};
static_assert(sizeof(PrReelInfo) == 28 * 8);

/// The bytes of a reel.json.
PR_EXPORT(PrReel*, pr_reel_new)(const char* text, std::uint32_t size);
PR_EXPORT(void, pr_reel_free)(PrReel* reel);
/// Valid as long as the reel.
PR_EXPORT(const PrReelInfo*, pr_reel_info)(const PrReel* reel);

enum PrText : std::int32_t {
  PR_TEXT_NAME = 0,             ///< for people
  PR_TEXT_CODEC = 1,            ///< "octree", "draco", "video"
  PR_TEXT_ENTROPY = 2,          ///< "none", "zstd", "context", ""
  PR_TEXT_LAYER = 3,            ///< the name of layer `index`
  PR_TEXT_TABLES_PATH = 4,      ///< beside reel.json; empty if it has none
  PR_TEXT_TABLES_CHECKSUM = 5,  ///< 16 hexadecimal digits
  PR_TEXT_SESSION = 6,          ///< of a live reel, 16 hexadecimal digits; else empty
  PR_TEXT_AUDIO_PATH = 7,       ///< Opus in Ogg, beside reel.json; empty if it has none
  PR_TEXT_SCALAR = 8,           ///< the name of scalar field `index`
};
PR_EXPORT(const char*, pr_reel_text)(const PrReel* reel, PrText which, std::uint32_t index);

struct PrScalarRange {
  double least, most;  ///< of the known values of all frames
  double labels;       ///< values are whole numbers that stand for something else
};
static_assert(sizeof(PrScalarRange) == 3 * 8);
/// Of scalar field `index`, below PrReelInfo::scalars.
PR_EXPORT(const PrScalarRange*, pr_reel_scalar)(const PrReel* reel, std::uint32_t index);

/// The times at which frames begin, in microseconds from the reel's start: an entry for each frame,
/// valid as long as the reel.
PR_EXPORT(const double*, pr_reel_times)(const PrReel* reel);

struct PrSegment {
  double number;       ///< of the segment
  double first_frame;  ///< its first
  double frames;
  double cube_origin[3], cube_edge;  ///< shared by its frames, for PrPrepare
};
static_assert(sizeof(PrSegment) == 7 * 8);
/// The segment that holds a frame below PrReelInfo::frames.
PR_EXPORT(const PrSegment*, pr_reel_segment)(const PrReel* reel, std::uint32_t frame);
/// Frames of a segment whose video is decoded from the first of them on. Without video, the frame
/// alone.
struct PrGroup {
  double first_frame, frames;
};
static_assert(sizeof(PrGroup) == 2 * 8);
PR_EXPORT(const PrGroup*, pr_reel_group)(const PrReel* reel, std::uint32_t frame);
/// The file of one layer of a segment, relative to reel.json.
PR_EXPORT(const char*, pr_reel_file)
(const PrReel* reel, std::uint32_t segment, std::uint32_t layer);
/// The file's size.
PR_EXPORT(double, pr_reel_file_bytes)
(const PrReel* reel, std::uint32_t segment, std::uint32_t layer);

/// Consecutive layers of a frame and which of their attributes (client/source/fetched.h). For a
/// Uint32Array.
struct PrLayers {
  std::uint32_t first, end;  ///< layers [first, end); the base is layer 0
  std::uint32_t colors, normals;
};
static_assert(sizeof(PrLayers) == 4 * 4);

/// Where the chunks of one layer of a frame are. They follow each other in the file.
struct PrRange {
  double layer;                      ///< its file is that of this layer and of the frame's segment
  double offset;                     ///< in that file
  double geometry, colors, normals;  ///< the sizes of the chunks; 0 for those not wanted
};
static_assert(sizeof(PrRange) == 5 * 8);
/// What to fetch for these layers of a frame: pr_reel_range_count entries, in their order. 0 if the
/// manifest says that a frame is larger than any frame is.
PR_EXPORT(const PrRange*, pr_reel_ranges)
(const PrReel* reel, std::uint32_t frame, const PrLayers* layers);
/// Of the last pr_reel_ranges.
PR_EXPORT(std::uint32_t, pr_reel_range_count)();

// ---- The camera -----------------------------------------------------------------------------

/// client/scene/camera.h, which explains all functions here. It belongs to the caller.
struct PrCamera {
  double target[3];
  double distance, yaw, pitch, fov_y, scene_radius;
  double up;  ///< the world's axis that points up: 1 x, 2 y, 3 z; negative: it points down
};
static_assert(sizeof(PrCamera) == 9 * 8);

/// A camera as it is before it looks at anything.
PR_EXPORT(void, pr_camera_init)(PrCamera* camera, double up);
/// `box`: min and max, 6 numbers.
PR_EXPORT(void, pr_camera_frame_bounds)(PrCamera* camera, const double* box, double aspect);
PR_EXPORT(void, pr_camera_fit)(PrCamera* camera, const double* box, double aspect, double covered);
PR_EXPORT(void, pr_camera_orbit)(PrCamera* camera, double yaw_by, double pitch_by);
PR_EXPORT(void, pr_camera_pan)(PrCamera* camera, double right_by, double up_by);
PR_EXPORT(void, pr_camera_zoom)(PrCamera* camera, double factor);
PR_EXPORT(void, pr_camera_zoom_at)
(PrCamera* camera, double factor, double cursor_x, double cursor_y, double aspect);
PR_EXPORT(void, pr_camera_center_on)(PrCamera* camera, double x, double y, double z);
PR_EXPORT(void, pr_camera_fly)
(PrCamera* camera, double x, double y, double z, double yaw_by, double pitch_by);

/// For a Float32Array. Matrices are column-major, as WebGL takes them.
struct PrMatrices {
  float view[16];        ///< from coordinates relative to the given origin to eye space
  float projection[16];  ///< to clip coordinates, with reversed depth: 1 near, 0 at infinity
  float to_clip[16];     ///< projection * view
  float near_plane;      ///< its distance
};
static_assert(sizeof(PrMatrices) == 49 * 4);
PR_EXPORT(const PrMatrices*, pr_camera_matrices)
(const PrCamera* camera, double origin_x, double origin_y, double origin_z, double aspect);
/// The eye (3 numbers), then the axes to the right, up and back (9 numbers), in the world.
PR_EXPORT(const double*, pr_camera_axes)(const PrCamera* camera);

/// client/scene/floor_grid.h. For a Float32Array.
struct PrFloorLine {
  float from[3], to[3];  ///< relative to pr_floor_origin
  float strength, step;
};
static_assert(sizeof(PrFloorLine) == 8 * 4);
/// The grid of a scene with these bounds (6 numbers) as the camera sees it: pr_floor_line_count
/// lines.
PR_EXPORT(const PrFloorLine*, pr_floor_lines)(const PrCamera* camera, const double* box);
/// Of the last pr_floor_lines.
PR_EXPORT(std::uint32_t, pr_floor_line_count)();
/// The origin (3 numbers), and the radius of the floor. Of the last pr_floor_lines.
PR_EXPORT(const double*, pr_floor_origin)();

// ---- What to fetch --------------------------------------------------------------------------

/// What is drawn of a frame (client/scene/draw_mode.h).
enum PrMode : std::int32_t { PR_SURFEL = 0, PR_VOXEL = 1, PR_POINT = 2, PR_STRIP = 3 };

/// The level of a frame that nothing makes finer (kWholeFrame).
inline constexpr std::int32_t PR_WHOLE_FRAME = 21;

/// The finest level that the camera can show of the reel in a picture of this size.
PR_EXPORT(std::int32_t, pr_level_for)
(const PrReel* reel, const PrCamera* camera, std::int32_t width, std::int32_t height,
 double pixel_size);
/// The finest level that a frame has with this many layers; PR_WHOLE_FRAME for all of them.
PR_EXPORT(std::int32_t, pr_level_of_layers)(const PrReel* reel, std::uint32_t layers);

/// How much is fetched given what the link and the machine can do
/// (client/playback/layer_control.h). The reel must live as long.
struct PrControl;

struct PrSituation {
  double now;            ///< seconds from any start; must not decrease
  double playing;        ///< else there is time for everything
  double frame_seconds;  ///< between two frames, at the current speed; > 0
  double fetched;        ///< how full the buffer of fetched frames is, 0 to 1
  double makeable;       ///< the share of frames to be made that have been fetched, 0 to 1
  double made;           ///< the share of them that are ready, 0 to 1
  double next_frame;     ///< the first that has not been fetched
};
static_assert(sizeof(PrSituation) == 7 * 8);

enum PrLimit : std::uint32_t {
  PR_LIMIT_NONE = 0,     ///< everything is fetched
  PR_LIMIT_ASKED = 1,    ///< the user asked for no more
  PR_LIMIT_VIEW = 2,     ///< more would not be seen
  PR_LIMIT_LINK = 3,     ///< the link carries no more
  PR_LIMIT_MACHINE = 4,  ///< the machine makes no more in time
};
/// For a Uint32Array.
struct PrDecision {
  PrLayers layers;  ///< from the base on
  PrLimit limit;
};
static_assert(sizeof(PrDecision) == 5 * 4);

/// `workers`: how many make frames. `link`: the reel comes over one that is slower than memory.
PR_EXPORT(PrControl*, pr_control_new)
(const PrReel* reel, std::uint32_t workers, std::int32_t link);
PR_EXPORT(void, pr_control_free)(PrControl* control);
/// What came since the last call, and for how many seconds at least one answer was coming.
PR_EXPORT(void, pr_control_carried)(PrControl* control, double bytes, double seconds);
/// A worker took this long to make a frame of this many layers.
PR_EXPORT(void, pr_control_made)(PrControl* control, std::uint32_t layers, double ms);
/// Those times do not count from now on, because frames are made differently.
PR_EXPORT(void, pr_control_forget_made)(PrControl* control);
/// Reconsiders; to be called a few times during each segment. 1 if decisions may differ from
/// before. `show_normals` and `scalars`: normals or a scalar field are shown; a field needs all
/// layers.
PR_EXPORT(std::int32_t, pr_control_update)
(PrControl* control, const PrSituation* situation, PrMode mode, std::int32_t show_normals,
 std::int32_t scalars);
/// What to fetch of frames that are seen down to `level`. `most`: the user wants no more layers.
PR_EXPORT(const PrDecision*, pr_control_decide)
(PrControl* control, PrMode mode, std::int32_t level, std::int32_t show_normals,
 std::int32_t scalars, std::uint32_t most);
/// The link's rate in bytes a second; 0: not known yet.
PR_EXPORT(double, pr_control_rate)(const PrControl* control);

/// Which frame follows which (client/playback/play_order.h). For an Int32Array.
struct PrOrder {
  std::int32_t count;        ///< frames of the reel
  std::int32_t loop;         ///< playback goes on at the other end
  std::int32_t direction;    ///< 1 or -1
  std::int32_t first, last;  ///< of the range that is played again and again; first -1: none
};
static_assert(sizeof(PrOrder) == 5 * 4);
/// The frame `steps` after `from`; -1 beyond an end, or once frames would only repeat.
PR_EXPORT(std::int32_t, pr_order_after)
(const PrOrder* order, std::uint32_t from, std::uint32_t steps);
/// How many steps after `from` playback first reaches `to`; -1 if it never does.
PR_EXPORT(std::int32_t, pr_order_steps)
(const PrOrder* order, std::uint32_t from, std::uint32_t to);

// ---- Time -----------------------------------------------------------------------------------

/// client/playback/clock.h, which explains all functions here.
struct PrClock;

struct PrReading {
  double position_us;
  double frame;
  double ordinal;
  double ended;
};
static_assert(sizeof(PrReading) == 4 * 8);

struct PrClockState {
  double playing, held;
  double speed;  ///< negative: backward
  double loop;
  double has_range;    ///< if not, what follows is 0
  double a_us, b_us;   ///< of the range
  double first, last;  ///< its frames
};
static_assert(sizeof(PrClockState) == 9 * 8);

/// `times_us`: as those of pr_reel_times, at least one; `duration_us` > 0. Paused at the start.
PR_EXPORT(PrClock*, pr_clock_new)
(const double* times_us, std::uint32_t count, double duration_us, std::int32_t loop);
PR_EXPORT(void, pr_clock_free)(PrClock* clock);
PR_EXPORT(const PrReading*, pr_clock_read)(const PrClock* clock, double now_us);
/// When the next frame begins or playback ends; -1 while time stands still.
PR_EXPORT(double, pr_clock_next_frame)(const PrClock* clock, double now_us);
PR_EXPORT(const PrClockState*, pr_clock_state)(const PrClock* clock);
/// The last frame that begins at or before a time.
PR_EXPORT(std::uint32_t, pr_clock_frame_at)(const PrClock* clock, double time_us);
PR_EXPORT(void, pr_clock_play)(PrClock* clock, double now_us);
PR_EXPORT(void, pr_clock_pause)(PrClock* clock, double now_us);
PR_EXPORT(void, pr_clock_hold)(PrClock* clock, double now_us);
PR_EXPORT(void, pr_clock_release)(PrClock* clock, double now_us);
PR_EXPORT(void, pr_clock_seek)(PrClock* clock, double time_us, double now_us);
PR_EXPORT(void, pr_clock_seek_by)(PrClock* clock, double delta_us, double now_us);
PR_EXPORT(void, pr_clock_step)(PrClock* clock, double frames, double now_us);
PR_EXPORT(void, pr_clock_set_speed)(PrClock* clock, double speed, double now_us);
PR_EXPORT(void, pr_clock_set_loop)(PrClock* clock, std::int32_t loop, double now_us);
/// a_us < 0: no range.
PR_EXPORT(void, pr_clock_set_loop_range)(PrClock* clock, double a_us, double b_us, double now_us);

// ---- Frames ---------------------------------------------------------------------------------

/// client/prepare/prepare.h: PrepareOptions and FrameInfo.
struct PrPrepare {
  double mode;                       ///< PrMode
  double level;                      ///< no finer one is prepared; PR_WHOLE_FRAME: all
  double delta;                      ///< of voxels; < 0: the desktop's default
  double show_normals;               ///< they are prepared in every mode
  double max_memory;                 ///< bytes that decoding may take; 0: the desktop's default
  double index;                      ///< of the frame in its reel, or its number in the stream
  double time_us;                    ///< from the reel's start, or when it was captured
  double cube_origin[3], cube_edge;  ///< PrSegment's; not needed for octree frames and files
  double normals_estimated;          ///< PrReelInfo's; 0 where there is none
};
static_assert(sizeof(PrPrepare) == 12 * 8);

/// How a scalar field is shown in place of colours (ScalarChoice).
struct PrScalar {
  double least, most;    ///< values at the ends of the ramp; least NaN: those of the source
  double known;          ///< the source has told of the field; if not, its frame does
  PrScalarRange source;  ///< what it has told
};
static_assert(sizeof(PrScalar) == 6 * 8);

/// Makes a frame ready to draw and keeps it under `key`, in place of one that was there. `bytes`:
/// the chunks of all layers, one after another. `sizes`: those of the geometry, colours and normals
/// of each layer; their sum is the number of bytes. `tables`: the reel's own, or 0. `field`: the
/// name of the scalar field to show, with its size in bytes; 0 bytes: none, and `scalar` does not
/// count.
PR_EXPORT(PrError, pr_prepare)
(std::uint32_t key, const std::uint8_t* bytes, const std::uint32_t* sizes, std::uint32_t layers,
 const PrTables* tables, const PrPrepare* options, const char* field, std::uint32_t field_size,
 const PrScalar* scalar);
/// The same from a whole PLY or Draco file, whose name begins the text of an error, without scalar
/// fields.
PR_EXPORT(PrError, pr_prepare_file)
(std::uint32_t key, const std::uint8_t* bytes, std::uint32_t size, const char* name,
 std::uint32_t name_size, const PrPrepare* options);

/// The video of a group (codec/video/video_frame.h). The browser decodes AV1, the module the rest.
struct PrVideo;
PR_EXPORT(PrVideo*, pr_video_new)();
PR_EXPORT(void, pr_video_free)(PrVideo* video);

/// A frame of a group that was read, but for its pictures. It may outlive its PrVideo.
struct PrVideoFrame {
  double width, height;  ///< of both pictures
  /// Where the temporal units of AV1 lie in the bytes that the frame was read from. Depth: 10 bits,
  /// 4:2:0. Colours: 8 bits, 4:2:0; without them, their size is 0.
  double depth_at, depth_size, colors_at, colors_size;
};
static_assert(sizeof(PrVideoFrame) == 6 * 8);
/// Reads the next frame of a group, or the first one of a new group, from its chunks. `sizes`: of
/// geometry, colours and normals. `max_memory` as in PrPrepare.
PR_EXPORT(PrVideoFrame*, pr_video_read)
(PrVideo* video, const std::uint8_t* bytes, const std::uint32_t* sizes, double max_memory);
PR_EXPORT(void, pr_video_frame_free)(PrVideoFrame* frame);

/// pr_prepare for a frame of video and its pictures: planes of width x height, without gaps.
/// `depth` is luma in 16 bits. `colors` is luma, then Cb and Cr of half the width and height; 0 if
/// it has none. The frame is not needed after that, and not freed.
PR_EXPORT(PrError, pr_prepare_video)
(std::uint32_t key, const PrVideoFrame* frame, const std::uint16_t* depth,
 const std::uint8_t* colors, const PrTables* tables, const PrPrepare* options);

struct PrFrame {
  double index, time_us;
  double points;    ///< of the source, as far as the frame tells
  double layers;    ///< that it was made of; 0 for a file
  double level;     ///< the finest that can be drawn of it; PR_WHOLE_FRAME: nothing is missing
  double depth;     ///< of its tree
  double elements;  ///< the most that a picture may have
  double is_cloud;  ///< it is drawn as points of a cloud, in surfel and point mode
  double normals_estimated;
  double memory;           ///< bytes that it takes
  double main_box_min[3];  ///< without a few points far away; min > max: it tells no size
  double main_box_max[3];
  double box_min[3], box_max[3];  ///< of all points; min > max if there are none
  double boxes_rough;             ///< the frame in more detail may tell other boxes
};
static_assert(sizeof(PrFrame) == 23 * 8);
/// 0 if there is none under this key.
PR_EXPORT(const PrFrame*, pr_frame)(std::uint32_t key);
/// What the colours of a frame mean (client/scene/legend.h), in lines: the name of the scalar
/// field; "ramp" or "labels"; then colours as six hexadecimal digits, each with a space and a text
/// behind it. Those of a ramp are at equal distances on it, with texts at its ends. Empty if the
/// frame shows no scalar field.
PR_EXPORT(const char*, pr_legend)(std::uint32_t key);
/// client/scene/view_box.h: the box (6 numbers) that a first view frames. `boxes`: the 12 numbers
/// of a PrFrame from main_box_min on.
PR_EXPORT(const double*, pr_view_box)(const double* bounds, const double* boxes);
PR_EXPORT(void, pr_drop)(std::uint32_t key);
PR_EXPORT(void, pr_drop_all)();

enum PrColor : std::int32_t {
  PR_COLORS = 0,
  PR_NORMALS = 1,
  PR_PLAIN = 2,
  // Of pixels, by pr_shading. Elements are packed with their own colours.
  PR_CURVATURE = 3,
  PR_ACCESSIBILITY = 4,
  PR_DEPTH = 5,
  PR_CONTOURS = 6,
};

struct PrView {
  PrCamera camera;
  double width, height;  ///< of the picture, in pixels; both > 0
  double pixel_size;     ///< DrawOptions::pixel_size; 1 by default
  /// The tangents of the frustum's slopes are multiplied by this, >= 1, so that the camera may turn
  /// and move a little before something is missing. Elements are as large as without it.
  double widen;
  double mode;        ///< PrMode, that of preparing the frame
  double color;       ///< PrColor
  double fill_holes;  ///< false: without the voxels that fill gaps
  double refine;      ///< divide surfels that look large (client/scene/refinement.h)
  double place[3];    ///< added to the frame's coordinates
};
static_assert(sizeof(PrView) == 20 * 8);

/// The box around the centres of instances, and their radii: client/render/region.h. It belongs to
/// the caller where it is passed.
struct PrBounds {
  double min[3], max[3];  ///< relative to the origin of the instances; min > max: there are none
  double radius;          ///< the largest
  double all_radii, count;
};
static_assert(sizeof(PrBounds) == 9 * 8);

struct PrPacked {
  double instances;  ///< pointer, aligned to 16 bytes
  double count;
  double origin[3];  ///< the zero of the instances' coordinates, in the world
  PrBounds bounds;
  double normals_estimated;             ///< the signs of normals mean nothing
  double visited, out_of_view, hidden;  ///< of the tree's nodes
  // Strips. The last `points` instances are representative surfels, which are drawn as points; the
  // others are vertices.
  double points;
  double indices;  ///< pointer to 32-bit indices of vertices; ~0 ends a strip
  /// How many indices: of triangles that face the eye, of others, and of those that are turned away
  /// (client/scene/strip_cut.h), in this order.
  double facing, mixed, turned_away;
  double light;        ///< with lighting: client/render/view.h, light_strength
  double one_back_in;  ///< client/render/hole_rules.h
};
static_assert(sizeof(PrPacked) == 25 * 8);

/// The elements of a frame that the camera sees, 32 bytes each (client/render/instance.h): centre
/// and radius as floats, the normal as four signed 16-bit numbers (times 32767), the colour as four
/// half floats in linear light. As an RGBA32UI texture, an instance is two texels.
PR_EXPORT(const PrPacked*, pr_pack)(std::uint32_t key, const PrView* view);

/// The part of a picture in which instances may be visible, as min_x, min_y, max_x, max_y from the
/// lower left corner: region_of. `to_clip`: 16 floats. For an Int32Array.
PR_EXPORT(const std::int32_t*, pr_region)
(const PrBounds* bounds, double scale, const float* to_clip, std::int32_t width,
 std::int32_t height, std::int32_t pixels);
PR_EXPORT(double, pr_nearest_depth)(const PrBounds* bounds, const float* to_clip, double near);
PR_EXPORT(double, pr_radius_in_pixels)
(const PrBounds* bounds, const float* to_clip, std::int32_t width, std::int32_t height);

/// What lights a scene (client/scene/draw_options.h).
enum PrLight : std::int32_t { PR_FLAT = 0, PR_STUDIO = 1, PR_ENVIRONMENT = 2 };

/// A picture of light (client/scene/radiance_picture.h).
struct PrEnvironment;
PR_EXPORT(PrEnvironment*, pr_environment_new)(const std::uint8_t* bytes, std::uint32_t size);
PR_EXPORT(void, pr_environment_free)(PrEnvironment* environment);

/// Light as it falls on surfaces of a roughness (client/render/light_probe.h). `environment`: 0 for
/// the studio.
struct PrProbe;
PR_EXPORT(PrProbe*, pr_probe_new)(const PrEnvironment* environment, double roughness);
PR_EXPORT(void, pr_probe_free)(PrProbe* probe);
/// LightProbe::glossy: the three colours of 34 by 34 texels as floats. Valid as long as the probe.
PR_EXPORT(const float*, pr_probe_glossy)(const PrProbe* probe);

/// What shading pixels needs: client/render/shading.h, the Shading block of shading.glsl. For a
/// Float32Array of 88 numbers. `bounds` are those of all instances, relative to the origin. With
/// flat light, `probe` is 0, and `lighting` tells whether it is over the viewer's shoulder or none.
PR_EXPORT(const float*, pr_shading)
(const PrCamera* camera, const PrBounds* bounds, double origin_x, double origin_y, double origin_z,
 PrColor color, PrLight light, std::int32_t lighting, double roughness, const PrProbe* probe);

// ---- Live streams ---------------------------------------------------------------------------

/// The messages of a live stream, assembled into frames (client/source/live_frames.h).
struct PrLive;
PR_EXPORT(PrLive*, pr_live_new)();
PR_EXPORT(void, pr_live_free)(PrLive* live);

enum PrMessage : std::int32_t {
  PR_MESSAGE_BAD = 0,  ///< it does not belong to a stream; pr_error_text says why
  PR_MESSAGE_HELLO = 1,
  PR_MESSAGE_DROPS = 2,
  PR_MESSAGE_END = 3,  ///< the publisher has disconnected; if it comes back, a hello follows
  PR_MESSAGE_UNKNOWN = 4,
};
PR_EXPORT(PrMessage, pr_live_text)(PrLive* live, const char* text, std::uint32_t size);
/// A binary message. A layer that does not fit those before it is counted as bad and left out.
PR_EXPORT(PrError, pr_live_layer)
(PrLive* live, const std::uint8_t* bytes, std::uint32_t size, double now_us);
struct PrLiveSound {
  double number;
  double capture_us;  ///< Unix time of the first sample, by the publisher's clock
  double samples;     ///< of each channel at 48,000 Hz
  double offset;      ///< where the packet of Opus begins in the message; it ends where that ends
};
static_assert(sizeof(PrLiveSound) == 4 * 8);
/// A binary message that begins with PRS1. 0: it is none of sound; pr_error_text says why.
PR_EXPORT(const PrLiveSound*, pr_live_sound)(const std::uint8_t* bytes, std::uint32_t size);
/// What follows comes over a new connection.
PR_EXPORT(void, pr_live_reconnected)(PrLive* live);

/// What the last hello said, as a reel without frames; 0 before the first hello. Valid until the
/// next message.
PR_EXPORT(const PrReel*, pr_live_reel)(const PrLive* live);

struct PrLiveFrame {
  double number;
  double capture_us;   ///< Unix time of the publisher's clock
  double layers;       ///< that have come, from the base on
  double layers_sent;  ///< by the publisher
  // Pointers, for pr_prepare:
  double bytes, size;
  double sizes;  ///< three 32-bit numbers for each layer
};
static_assert(sizeof(PrLiveFrame) == 7 * 8);
/// A frame newer than the last one given, or the same with more layers: LiveSource::next. 0 if
/// there is none yet; that is no error.
PR_EXPORT(const PrLiveFrame*, pr_live_next)(PrLive* live, double now_us);
/// When pr_live_next gives a frame although no message comes; -1: never.
PR_EXPORT(double, pr_live_due)(const PrLive* live);

/// client/source/live_source.h: LiveCounts.
struct PrLiveCounts {
  double frames, skipped, dropped, bad, reconnections, bytes;
};
static_assert(sizeof(PrLiveCounts) == 6 * 8);
PR_EXPORT(const PrLiveCounts*, pr_live_counts)(const PrLive* live);
