/* Pointreel for C: reads reels and live streams of point clouds, decodes and encodes frames, and
 * writes packages.
 *
 * Errors. Functions that can fail return a pointreel_status. After any other than POINTREEL_OK,
 * pointreel_error_message() says why, in one line for a person; the message belongs to the calling
 * thread and lasts until its next call that fails. Whatever a failed function was to give is then
 * NULL or 0.
 *
 * Handles. Objects are named by handles, which are closed by the function for their kind. NULL may
 * be closed too. A handle that is NULL, closed or of another kind is POINTREEL_ARGUMENT: handles
 * are numbers that are never used twice, not addresses.
 *
 * Threads. Every function may be called by any thread at any time, also with the same handle, and
 * also while another thread closes it: the object then lasts until the call has returned. Threads
 * read frames of one reel at the same time. Calls with the same writer, or pointreel_live_next with
 * the same stream, wait for each other. Decoding and encoding use all processors, by TBB's threads.
 * The library must not be used by a process that was forked from one that uses it. Once loaded it
 * stays: dlclose does not remove it.
 *
 * To stop a call that takes long, make a pointreel_canceller, pass it in the options, and let
 * another thread call pointreel_cancel: calls that were given it return POINTREEL_CANCELLED soon,
 * now and later. Reading over a network waits for as long as a server does not answer, unless it is
 * cancelled.
 *
 * Options. Set struct_size to sizeof the struct, and all other members to 0 for their defaults: a
 * library that is newer than the program knows by it which members there are. NULL stands for all
 * defaults.
 *
 * Input may be hostile. Files, servers' answers and encoded bytes may be anything: what is damaged
 * is an error, and memory is bounded. Pointers and counts of arrays have to be right.
 *
 * Text is UTF-8. Arrays of points hold three numbers for each point, without gaps. */
#ifndef POINTREEL_H
#define POINTREEL_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#if defined(__GNUC__)
#define POINTREEL_API __attribute__((visibility("default")))
#else
#define POINTREEL_API
#endif

typedef enum pointreel_status {
  POINTREEL_OK = 0,
  POINTREEL_INVALID = 1,     /* the input is damaged, or breaks the rules of its format */
  POINTREEL_UNSUPPORTED = 2, /* the input is of a newer version of its format */
  POINTREEL_LIMIT = 3,       /* more than a format, the caller or the memory allows */
  POINTREEL_ARGUMENT = 4,    /* a value out of range, or a handle that is closed */
  POINTREEL_NOT_FOUND = 5,   /* there is no such file, reel, frame or attribute */
  POINTREEL_IO = 6,          /* the file system or the network failed */
  POINTREEL_CANCELLED = 7,   /* pointreel_cancel was called */
  POINTREEL_TIMEOUT = 8,     /* nothing has come by then */
  POINTREEL_INTERNAL = 9,    /* a fault of Pointreel */
  POINTREEL_REFUSED = 10     /* the server will not do this, for instance without a token */
} pointreel_status;

typedef struct pointreel_canceller pointreel_canceller;
typedef struct pointreel_reel pointreel_reel;
typedef struct pointreel_live pointreel_live;
typedef struct pointreel_frame pointreel_frame;
typedef struct pointreel_bytes pointreel_bytes;
typedef struct pointreel_writer pointreel_writer;

/* "0.1.0" */
POINTREEL_API const char* pointreel_version(void);
/* Of the calling thread; "" if no call has failed. Never NULL. */
POINTREEL_API const char* pointreel_error_message(void);

/* --- Cancelling ------------------------------------------------------------------------------- */

POINTREEL_API pointreel_status pointreel_canceller_create(pointreel_canceller** canceller);
/* Cancels all calls that have been, or will be, given this canceller. */
POINTREEL_API pointreel_status pointreel_cancel(pointreel_canceller* canceller);
/* Calls that have it go on, and can no longer be cancelled by it. */
POINTREEL_API void pointreel_canceller_close(pointreel_canceller* canceller);

/* --- Frames ----------------------------------------------------------------------------------- */

/* How to read. */
typedef struct pointreel_read_options {
  size_t struct_size;
  uint32_t layers;     /* decode the first layers only, from coarse to fine; 0: all */
  uint64_t max_memory; /* bytes that decoding a frame may take; 0: 1 GiB */
  pointreel_canceller* canceller;
} pointreel_read_options;

typedef struct pointreel_frame_info {
  size_t struct_size;
  uint64_t points;
  uint32_t index;   /* in the reel, or its number in the live stream */
  uint32_t layers;  /* that it was decoded from; 0 for a file */
  uint64_t time_us; /* from the reel's start; live: when it was captured, as Unix time */
  double origin[3]; /* positions are relative to it */
  int32_t has_colors, has_normals;
} pointreel_frame_info;

/* `info->struct_size` has to be set. */
POINTREEL_API pointreel_status pointreel_frame_get_info(const pointreel_frame* frame,
                                                        pointreel_frame_info* info);

/* Copy an attribute into the caller's array, which has room for `capacity` points, and set *count
 * to the number of points. With too little room nothing is copied, and the status is
 * POINTREEL_LIMIT; with `values` NULL and a capacity of 0 they only count. POINTREEL_NOT_FOUND if
 * the frame does not have the attribute. */
/* Relative to the frame's origin. */
POINTREEL_API pointreel_status pointreel_frame_get_positions(const pointreel_frame* frame,
                                                             float* values, size_t capacity,
                                                             size_t* count);
/* In the coordinates of the source: origin + position. */
POINTREEL_API pointreel_status pointreel_frame_get_world_positions(const pointreel_frame* frame,
                                                                   double* values, size_t capacity,
                                                                   size_t* count);
/* sRGB */
POINTREEL_API pointreel_status pointreel_frame_get_colors_8(const pointreel_frame* frame,
                                                            uint8_t* values, size_t capacity,
                                                            size_t* count);
POINTREEL_API pointreel_status pointreel_frame_get_colors_16(const pointreel_frame* frame,
                                                             uint16_t* values, size_t capacity,
                                                             size_t* count);
/* Of unit length, or zero where unknown. */
POINTREEL_API pointreel_status pointreel_frame_get_normals(const pointreel_frame* frame,
                                                           float* values, size_t capacity,
                                                           size_t* count);

/* Scalar fields: a number for each point, such as its intensity or class, NaN where it is unknown.
 * The names of those that the frame has, from 0 on; NULL behind the last one, and if there is no
 * such frame. A name lasts as long as the frame is not closed. */
POINTREEL_API const char* pointreel_frame_scalar_name(const pointreel_frame* frame, size_t number);
/* One number for each point, of the field of that name. */
POINTREEL_API pointreel_status pointreel_frame_get_scalar(const pointreel_frame* frame,
                                                          const char* name, float* values,
                                                          size_t capacity, size_t* count);

/* The frame's own arrays, without a copy, as long as the frame is not closed. NULL if it does not
 * have the attribute or there is no such frame. */
POINTREEL_API const float* pointreel_frame_positions(const pointreel_frame* frame);
POINTREEL_API const uint16_t* pointreel_frame_colors(const pointreel_frame* frame); /* 16 bits */
POINTREEL_API const float* pointreel_frame_normals(const pointreel_frame* frame);
POINTREEL_API const float* pointreel_frame_scalar(const pointreel_frame* frame, const char* name);

POINTREEL_API void pointreel_frame_close(pointreel_frame* frame);

/* --- Reels ------------------------------------------------------------------------------------ */

typedef struct pointreel_open_options {
  size_t struct_size;
  double fps;          /* of folders of files, which do not tell it; 0: 30, or as recorded */
  const char* token;   /* bearer token for servers, or NULL */
  const char* ca_file; /* certificates to trust for https and wss, as PEM; NULL: the system's */
  int32_t follow_redirects;       /* also to other hosts; never from https to http */
  pointreel_canceller* canceller; /* for opening */
} pointreel_open_options;

typedef struct pointreel_reel_info {
  size_t struct_size;
  uint32_t frames; /* that are shown: a cut of video may list more in its metadata */
  uint32_t layers; /* of its frames, from coarse to fine; 0 for files */
  double fps;      /* nominal; the times of the frames are authoritative */
  uint64_t duration_us;
  double bounds_min[3], bounds_max[3]; /* of all frames; min > max if no frame has a point */
  int32_t has_colors, has_normals;     /* any frame */
  char up; /* the axis that points up: 'x', 'y' or 'z', or in capitals if it points down */
} pointreel_reel_info;

/* `where`: the folder of a package or its reel.json, an http:// or https:// address of either, an
 * s3:// address, whose store and keys the environment and ~/.aws name, a folder of PLY and Draco
 * files, or one such file. */
POINTREEL_API pointreel_status pointreel_reel_open(const char* where,
                                                   const pointreel_open_options* options,
                                                   pointreel_reel** reel);
/* `info->struct_size` has to be set. */
POINTREEL_API pointreel_status pointreel_reel_get_info(const pointreel_reel* reel,
                                                       pointreel_reel_info* info);
/* The text of the reel's reel.json, with a 0 at its end: name, codec and all else that is known.
 * Sets *length to its length without the 0. With less than length + 1 bytes of room nothing is
 * copied, and the status is POINTREEL_LIMIT; with `text` NULL and a capacity of 0 it is only
 * counted. */
POINTREEL_API pointreel_status pointreel_reel_get_metadata(const pointreel_reel* reel, char* text,
                                                           size_t capacity, size_t* length);
POINTREEL_API pointreel_status pointreel_reel_get_frame_time(const pointreel_reel* reel,
                                                             uint32_t index, uint64_t* time_us);
/* Why nothing comes over the network at present, as one line; "" when all is well. As
 * pointreel_reel_get_metadata. */
POINTREEL_API pointreel_status pointreel_reel_get_trouble(const pointreel_reel* reel, char* text,
                                                          size_t capacity, size_t* length);
/* Fetches and decodes a frame. */
POINTREEL_API pointreel_status pointreel_reel_read(pointreel_reel* reel, uint32_t index,
                                                   const pointreel_read_options* options,
                                                   pointreel_frame** frame);
/* Frames that were read from it stay. */
POINTREEL_API void pointreel_reel_close(pointreel_reel* reel);

/* --- Live streams ----------------------------------------------------------------------------- */

/* `url`: ws(s)://HOST/live/NAME, or http(s)://HOST/live/NAME/reel.json. Connects in the background,
 * and again whenever the connection breaks. The canceller of the options ends all waiting. */
POINTREEL_API pointreel_status pointreel_live_open(const char* url,
                                                   const pointreel_open_options* options,
                                                   pointreel_live** live);
/* Waits for a frame newer than the last one, and decodes it. Older frames are skipped. A frame
 * whose finest layers come late is given again with more layers. POINTREEL_TIMEOUT if none has
 * come; pointreel_live_get_trouble may then say why. */
POINTREEL_API pointreel_status pointreel_live_next(pointreel_live* live, uint32_t timeout_ms,
                                                   const pointreel_read_options* options,
                                                   pointreel_frame** frame);
/* As pointreel_reel_get_trouble. */
POINTREEL_API pointreel_status pointreel_live_get_trouble(const pointreel_live* live, char* text,
                                                          size_t capacity, size_t* length);
POINTREEL_API void pointreel_live_close(pointreel_live* live);

/* --- Encoding --------------------------------------------------------------------------------- */

/* A scalar field. Frames have at most 8, with different names of at most 64 bytes. */
typedef struct pointreel_scalar {
  const char* name;
  const float* values; /* one for each point; NaN where it is unknown */
} pointreel_scalar;

/* The caller's points, which are copied. Points without a finite position are left out. */
typedef struct pointreel_points {
  size_t struct_size;
  size_t count;
  const float* positions;        /* relative to the origin; or NULL, and instead of them */
  const double* world_positions; /* in the coordinates of the source */
  double origin[3];              /* of `positions` */
  const uint8_t* colors_8;       /* sRGB; of colours, one of the two or neither */
  const uint16_t* colors_16;
  const float* normals;            /* of any length, or zero where unknown; or NULL */
  const pointreel_scalar* scalars; /* Draco frames leave them out */
  size_t scalar_count;
} pointreel_points;

typedef enum pointreel_codec { POINTREEL_OCTREE = 0, POINTREEL_DRACO = 1 } pointreel_codec;

/* Each with a default for 0. The qualities are explained in QUALITY.md. */
typedef struct pointreel_encode_options {
  size_t struct_size;
  int32_t codec;          /* a pointreel_codec */
  int32_t depth;          /* octree: levels, 1 to 21; 0: by the points. Draco: bits; 0: 11 */
  double voxel;           /* octree: edge of a voxel, which determines the depth; 0: by `depth` */
  int32_t color_quality;  /* octree: 1 to 100 (lossless); 0: 64 */
  int32_t normal_quality; /* octree: 1 to 100 (best); 0: 43 */
  int32_t fast; /* octree: larger frames that decode in half the time, as live streams have */
} pointreel_encode_options;

/* Encodes a single frame. POINTREEL_LIMIT if a layer of it takes more than 64 MiB. */
POINTREEL_API pointreel_status pointreel_encode(const pointreel_points* points,
                                                const pointreel_encode_options* options,
                                                pointreel_bytes** bytes);
/* NULL, and 0, if there are no such bytes. They last until they are closed. */
POINTREEL_API const uint8_t* pointreel_bytes_data(const pointreel_bytes* bytes);
POINTREEL_API size_t pointreel_bytes_size(const pointreel_bytes* bytes);
POINTREEL_API void pointreel_bytes_close(pointreel_bytes* bytes);

/* Decodes what pointreel_encode made, or a whole PLY or Draco file. */
POINTREEL_API pointreel_status pointreel_decode(const void* data, size_t size,
                                                const pointreel_read_options* options,
                                                pointreel_frame** frame);

/* --- Packages --------------------------------------------------------------------------------- */

typedef struct pointreel_write_options {
  size_t struct_size;
  const char* name;        /* of the reel, for people; NULL: that of the folder */
  double fps;              /* 0: 30 */
  char up;                 /* the axis that points up, as in pointreel_reel_info; 0: 'y' */
  int32_t replace;         /* whether a package that is already there is replaced */
  uint32_t segment_frames; /* frames that share a file, and are encoded together; 0: 30 */
  pointreel_canceller* canceller;
} pointreel_write_options;

/* A package that is complete once pointreel_writer_finish has returned, and absent otherwise. */
POINTREEL_API pointreel_status pointreel_writer_open(const char* folder,
                                                     const pointreel_write_options* options,
                                                     const pointreel_encode_options* encode,
                                                     pointreel_writer** writer);
/* Adds a frame, which is shown at `time_us` from the reel's start, or with POINTREEL_BY_FPS one
 * frame's time after the frame before. From time to time it encodes what was added since. Errors
 * may name options of pointreel-server pack, of which segment_frames is --segment. */
#define POINTREEL_BY_FPS UINT64_MAX
POINTREEL_API pointreel_status pointreel_writer_add(pointreel_writer* writer,
                                                    const pointreel_points* points,
                                                    uint64_t time_us);
POINTREEL_API pointreel_status pointreel_writer_finish(pointreel_writer* writer);
/* Without pointreel_writer_finish, nothing remains of the package. */
POINTREEL_API void pointreel_writer_close(pointreel_writer* writer);

#ifdef __cplusplus
}
#endif

#endif
