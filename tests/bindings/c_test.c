/* The C interface, as a program in C uses it.
 *
 *   c_test FOLDER [REEL_URL LIVE_URL]
 *
 * Writes into FOLDER. The addresses are those of a server of FOLDER/reel, which somebody makes once
 * this program has written it and waits in standard input, and of a live stream. */
#define _POSIX_C_SOURCE 200809L
#include <math.h>
#include <pointreel.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

/* The layout of structs is part of the ABI, on machines with 64 bits. */
_Static_assert(sizeof(pointreel_read_options) == 32, "pointreel_read_options");
_Static_assert(sizeof(pointreel_frame_info) == 64, "pointreel_frame_info");
_Static_assert(sizeof(pointreel_open_options) == 48, "pointreel_open_options");
_Static_assert(sizeof(pointreel_reel_info) == 96, "pointreel_reel_info");
_Static_assert(sizeof(pointreel_points) == 96, "pointreel_points");
_Static_assert(sizeof(pointreel_encode_options) == 40, "pointreel_encode_options");
_Static_assert(sizeof(pointreel_write_options) == 48, "pointreel_write_options");

#define EXPECT(condition)                                                        \
  do {                                                                           \
    if (!(condition)) {                                                          \
      fprintf(stderr, "%s:%d: not so: %s; %s\n", __FILE__, __LINE__, #condition, \
              pointreel_error_message());                                        \
      exit(1);                                                                   \
    }                                                                            \
  } while (0)
#define TEST(sentence) (printf("%s\n", sentence), fflush(stdout))

enum { kPoints = 1000, kFrames = 7 };

static char reel_path[4096];
static float positions[kPoints][3];
static double world[kPoints][3];
static uint8_t colors[kPoints][3];
static float normals[kPoints][3];

/* A lattice, whose points decode to themselves. */
static pointreel_points make_points(int frame) {
  for (int i = 0; i < kPoints; ++i) {
    const int cell[3] = {i % 10, i / 10 % 10, i / 100};
    for (int axis = 0; axis < 3; ++axis) {
      positions[i][axis] = (float)cell[axis];
      colors[i][axis] = (uint8_t)((i * (axis + 1) + frame) % 256);
      normals[i][axis] = axis == i % 3 ? 2.0f : 0.0f;
    }
  }
  pointreel_points points = {0};
  points.struct_size = sizeof points;
  points.count = kPoints;
  points.positions = &positions[0][0];
  points.origin[0] = 1000.0 + frame;
  points.colors_8 = &colors[0][0];
  points.normals = &normals[0][0];
  return points;
}

static pointreel_encode_options lossless(void) {
  pointreel_encode_options options = {0};
  options.struct_size = sizeof options;
  options.color_quality = 100;
  options.normal_quality = 100;
  return options;
}

static size_t count_of(const pointreel_frame* frame) {
  size_t count = 0;
  EXPECT(pointreel_frame_get_positions(frame, NULL, 0, &count) == POINTREEL_OK);
  return count;
}

static void check_frame(const pointreel_frame* frame, int number) {
  pointreel_frame_info info = {0};
  info.struct_size = sizeof info;
  EXPECT(pointreel_frame_get_info(frame, &info) == POINTREEL_OK);
  EXPECT(info.points == kPoints && count_of(frame) == kPoints);
  EXPECT(info.has_colors && info.has_normals);
  static _Thread_local double at[kPoints][3];
  static _Thread_local float local[kPoints][3];
  static _Thread_local uint8_t rgb[kPoints][3];
  static _Thread_local uint16_t rgb16[kPoints][3];
  static _Thread_local float direction[kPoints][3];
  size_t count = 0;
  EXPECT(pointreel_frame_get_world_positions(frame, &at[0][0], kPoints, &count) == POINTREEL_OK);
  EXPECT(pointreel_frame_get_positions(frame, &local[0][0], kPoints, NULL) == POINTREEL_OK);
  EXPECT(pointreel_frame_get_colors_8(frame, &rgb[0][0], kPoints, NULL) == POINTREEL_OK);
  EXPECT(pointreel_frame_get_colors_16(frame, &rgb16[0][0], kPoints, NULL) == POINTREEL_OK);
  EXPECT(pointreel_frame_get_normals(frame, &direction[0][0], kPoints, NULL) == POINTREEL_OK);
  EXPECT(count == kPoints);
  int seen[kPoints] = {0};
  for (int i = 0; i < kPoints; ++i) {
    const int x = (int)lround(at[i][0] - 1000.0 - number);
    const int source = x + 10 * (int)lround(at[i][1]) + 100 * (int)lround(at[i][2]);
    EXPECT(source >= 0 && source < kPoints && seen[source]++ == 0);
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT(rgb[i][axis] == (source * (axis + 1) + number) % 256);
      EXPECT(rgb16[i][axis] == 257 * rgb[i][axis]);
      EXPECT(fabs(local[i][axis] + info.origin[axis] - at[i][axis]) < 1e-6);
      EXPECT(fabsf(direction[i][axis] - (axis == source % 3 ? 1.0f : 0.0f)) < 0.02f);
    }
  }
  EXPECT(memcmp(pointreel_frame_positions(frame), local, sizeof local) == 0);
  EXPECT(memcmp(pointreel_frame_colors(frame), rgb16, sizeof rgb16) == 0);
  EXPECT(memcmp(pointreel_frame_normals(frame), direction, sizeof direction) == 0);
}

static void scalar_fields_come_back_by_name(void) {
  TEST("scalar fields come back by name");
  static float positions[kPoints][3], heat[kPoints], kind[kPoints];
  for (int i = 0; i < kPoints; ++i) {
    positions[i][0] = (float)(i % 10);
    positions[i][1] = (float)(i / 10);
    heat[i] = (float)i / 2.0f;
    kind[i] = i % 3 == 0 ? NAN : 4.0f;
  }
  const pointreel_scalar scalars[] = {{"heat", heat}, {"class", kind}};
  pointreel_points points = {0};
  points.struct_size = sizeof points;
  points.count = kPoints;
  points.positions = &positions[0][0];
  points.scalars = scalars;
  points.scalar_count = 2;
  pointreel_bytes* bytes = NULL;
  pointreel_frame* frame = NULL;
  EXPECT(pointreel_encode(&points, NULL, &bytes) == POINTREEL_OK);
  EXPECT(pointreel_decode(pointreel_bytes_data(bytes), pointreel_bytes_size(bytes), NULL, &frame) ==
         POINTREEL_OK);
  EXPECT(strcmp(pointreel_frame_scalar_name(frame, 0), "heat") == 0);
  EXPECT(strcmp(pointreel_frame_scalar_name(frame, 1), "class") == 0);
  EXPECT(pointreel_frame_scalar_name(frame, 2) == NULL);
  float room[kPoints];
  size_t count = 0;
  EXPECT(pointreel_frame_get_scalar(frame, "heat", NULL, 0, &count) == POINTREEL_OK);
  EXPECT(count == kPoints);
  EXPECT(pointreel_frame_get_scalar(frame, "heat", room, kPoints - 1, NULL) == POINTREEL_LIMIT);
  EXPECT(pointreel_frame_get_scalar(frame, "heat", room, kPoints, NULL) == POINTREEL_OK);
  EXPECT(memcmp(pointreel_frame_scalar(frame, "heat"), room, sizeof room) == 0);
  const float* local = pointreel_frame_positions(frame);
  const float* labels = pointreel_frame_scalar(frame, "class");
  pointreel_frame_info info = {0};
  info.struct_size = sizeof info;
  EXPECT(pointreel_frame_get_info(frame, &info) == POINTREEL_OK);
  for (size_t i = 0; i < kPoints; ++i) {
    const long source =
        lround(local[3 * i] + info.origin[0]) + 10 * lround(local[3 * i + 1] + info.origin[1]);
    EXPECT(source >= 0 && source < kPoints);
    EXPECT(fabsf(room[i] - heat[source]) <= 0.5f * heat[kPoints - 1] / 255.0f * 1.01f);
    EXPECT(source % 3 == 0 ? isnan(labels[i]) : labels[i] == 4.0f);
  }
  EXPECT(pointreel_frame_get_scalar(frame, "cold", room, kPoints, NULL) == POINTREEL_NOT_FOUND);
  EXPECT(pointreel_frame_scalar(frame, NULL) == NULL);
  pointreel_frame_close(frame);
  pointreel_bytes_close(bytes);
  points.scalar_count = 9;
  EXPECT(pointreel_encode(&points, NULL, &bytes) == POINTREEL_ARGUMENT);
  const pointreel_scalar unnamed[] = {{NULL, heat}};
  points.scalars = unnamed;
  points.scalar_count = 1;
  EXPECT(pointreel_encode(&points, NULL, &bytes) == POINTREEL_ARGUMENT);
}

static pointreel_reel* open_reel(const char* where) {
  pointreel_reel* reel = NULL;
  EXPECT(pointreel_reel_open(where, NULL, &reel) == POINTREEL_OK && reel != NULL);
  return reel;
}

static void a_package_is_written_frame_by_frame(void) {
  TEST("a package is written frame by frame");
  pointreel_write_options options = {0};
  options.struct_size = sizeof options;
  options.name = "a lattice";
  options.fps = 25.0;
  options.up = 'Z';
  options.segment_frames = 3;
  const pointreel_encode_options encode = lossless();
  pointreel_writer* writer = NULL;
  EXPECT(pointreel_writer_open(reel_path, &options, &encode, &writer) == POINTREEL_OK);
  for (int i = 0; i < kFrames; ++i) {
    const pointreel_points points = make_points(i);
    const uint64_t time = i < 5 ? POINTREEL_BY_FPS : 1000000u * (unsigned)i;
    EXPECT(pointreel_writer_add(writer, &points, time) == POINTREEL_OK);
  }
  EXPECT(pointreel_writer_finish(writer) == POINTREEL_OK);
  EXPECT(pointreel_writer_finish(writer) == POINTREEL_ARGUMENT);
  pointreel_writer_close(writer);
  EXPECT(pointreel_writer_finish(writer) == POINTREEL_ARGUMENT);
  EXPECT(strstr(pointreel_error_message(), "closed") != NULL);
  EXPECT(pointreel_writer_open(reel_path, &options, &encode, &writer) == POINTREEL_ARGUMENT);
  EXPECT(writer == NULL && strstr(pointreel_error_message(), "exists") != NULL);
}

static void a_package_that_is_not_finished_is_absent(void) {
  TEST("a package that is not finished is absent");
  char path[4200];
  snprintf(path, sizeof path, "%s.unfinished", reel_path);
  pointreel_writer* writer = NULL;
  EXPECT(pointreel_writer_open(path, NULL, NULL, &writer) == POINTREEL_OK);
  const pointreel_points points = make_points(0);
  EXPECT(pointreel_writer_add(writer, &points, 0) == POINTREEL_OK);
  pointreel_writer_close(writer);
  pointreel_reel* reel = NULL;
  EXPECT(pointreel_reel_open(path, NULL, &reel) == POINTREEL_NOT_FOUND && reel == NULL);
}

static void frames_are_read_by_index_and_layers(const char* where) {
  TEST("frames are read by index and layers");
  pointreel_reel* reel = open_reel(where);
  pointreel_reel_info info = {0};
  info.struct_size = sizeof info;
  EXPECT(pointreel_reel_get_info(reel, &info) == POINTREEL_OK);
  EXPECT(info.frames == kFrames && info.fps == 25.0 && info.up == 'Z');
  EXPECT(info.has_colors && info.has_normals && info.layers >= 1);
  EXPECT(info.bounds_min[0] == 1000.0 && info.bounds_max[0] == 1009.0 + kFrames - 1);
  for (uint32_t i = 0; i < kFrames; ++i) {
    pointreel_frame* frame = NULL;
    EXPECT(pointreel_reel_read(reel, i, NULL, &frame) == POINTREEL_OK);
    check_frame(frame, (int)i);
    pointreel_frame_info read = {0};
    read.struct_size = sizeof read;
    EXPECT(pointreel_frame_get_info(frame, &read) == POINTREEL_OK);
    EXPECT(read.index == i && read.layers == info.layers);
    uint64_t time = 0;
    EXPECT(pointreel_reel_get_frame_time(reel, i, &time) == POINTREEL_OK);
    EXPECT(time == read.time_us && time == (i < 5 ? 40000u * i : 1000000u * i));
    pointreel_frame_close(frame);
  }
  pointreel_read_options coarse = {0};
  coarse.struct_size = sizeof coarse;
  coarse.layers = 1;
  pointreel_frame* frame = NULL;
  EXPECT(pointreel_reel_read(reel, 0, &coarse, &frame) == POINTREEL_OK);
  pointreel_frame_info read = {0};
  read.struct_size = sizeof read;
  EXPECT(pointreel_frame_get_info(frame, &read) == POINTREEL_OK && read.layers == 1);
  pointreel_reel_close(reel);
  EXPECT(count_of(frame) > 0); /* frames stay */
  pointreel_frame_close(frame);

  reel = open_reel(where);
  size_t length = 0;
  EXPECT(pointreel_reel_get_metadata(reel, NULL, 0, &length) == POINTREEL_OK && length > 0);
  char* text = malloc(length + 1);
  EXPECT(text != NULL);
  EXPECT(pointreel_reel_get_metadata(reel, text, length, NULL) == POINTREEL_LIMIT);
  EXPECT(pointreel_reel_get_metadata(reel, text, length + 1, NULL) == POINTREEL_OK);
  EXPECT(strlen(text) == length && strstr(text, "a lattice") != NULL);
  free(text);
  char none[8] = "x";
  EXPECT(pointreel_reel_get_trouble(reel, none, sizeof none, &length) == POINTREEL_OK);
  EXPECT(length == 0 && none[0] == '\0');
  pointreel_reel_close(reel);
}

static void frames_are_encoded_and_decoded(void) {
  TEST("frames are encoded and decoded");
  const pointreel_points points = make_points(3);
  const pointreel_encode_options options = lossless();
  pointreel_bytes* bytes = NULL;
  EXPECT(pointreel_encode(&points, &options, &bytes) == POINTREEL_OK);
  const uint8_t* data = pointreel_bytes_data(bytes);
  const size_t size = pointreel_bytes_size(bytes);
  EXPECT(size > 0 && size < kPoints * 18);
  pointreel_frame* frame = NULL;
  EXPECT(pointreel_decode(data, size, NULL, &frame) == POINTREEL_OK);
  check_frame(frame, 3);
  pointreel_frame_close(frame);

  pointreel_points doubles = points;
  for (int i = 0; i < kPoints; ++i)
    for (int axis = 0; axis < 3; ++axis)
      world[i][axis] = positions[i][axis] + (axis == 0 ? 1003.0 : 0.0);
  doubles.positions = NULL;
  doubles.world_positions = &world[0][0];
  pointreel_bytes* again = NULL;
  EXPECT(pointreel_encode(&doubles, &options, &again) == POINTREEL_OK);
  EXPECT(pointreel_decode(pointreel_bytes_data(again), pointreel_bytes_size(again), NULL, &frame) ==
         POINTREEL_OK);
  check_frame(frame, 3);
  pointreel_frame_close(frame);
  pointreel_bytes_close(again);

  pointreel_encode_options draco = {0};
  draco.struct_size = sizeof draco;
  draco.codec = POINTREEL_DRACO;
  EXPECT(pointreel_encode(&points, &draco, &again) == POINTREEL_OK);
  EXPECT(pointreel_decode(pointreel_bytes_data(again), pointreel_bytes_size(again), NULL, &frame) ==
         POINTREEL_OK);
  EXPECT(count_of(frame) == kPoints);
  pointreel_frame_close(frame);
  pointreel_bytes_close(again);

  TEST("every encoded frame that is cut off or damaged is an error");
  for (size_t cut = 0; cut < size; ++cut) {
    EXPECT(pointreel_decode(data, cut, NULL, &frame) == POINTREEL_INVALID && frame == NULL);
    EXPECT(pointreel_error_message()[0] != '\0');
  }
  uint8_t* damaged = malloc(size);
  EXPECT(damaged != NULL);
  for (size_t i = 0; i < size; ++i) {
    memcpy(damaged, data, size);
    damaged[i] ^= 0x10;
    /* Some checksum covers each byte. */
    const pointreel_status status = pointreel_decode(damaged, size, NULL, &frame);
    EXPECT(status != POINTREEL_OK && status != POINTREEL_INTERNAL);
  }
  free(damaged);
  const char ply[] =
      "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n"
      "property float z\nend_header\n1 2 3\n4 5 6\n";
  EXPECT(pointreel_decode(ply, sizeof ply - 1, NULL, &frame) == POINTREEL_OK);
  EXPECT(count_of(frame) == 2 && pointreel_frame_colors(frame) == NULL);
  float room[6];
  EXPECT(pointreel_frame_get_normals(frame, room, 2, NULL) == POINTREEL_NOT_FOUND);
  pointreel_frame_close(frame);
  pointreel_bytes_close(bytes);
  EXPECT(pointreel_bytes_data(bytes) == NULL && pointreel_bytes_size(bytes) == 0);
}

static void wrong_arguments_are_errors(void) {
  TEST("wrong arguments are errors");
  pointreel_reel* reel = NULL;
  pointreel_frame* frame = NULL;
  pointreel_bytes* bytes = NULL;
  pointreel_writer* writer = NULL;
  EXPECT(pointreel_reel_open(NULL, NULL, &reel) == POINTREEL_ARGUMENT);
  EXPECT(pointreel_reel_open("/nowhere/at/all", NULL, &reel) == POINTREEL_NOT_FOUND);
  EXPECT(pointreel_reel_open("gopher://host/reel", NULL, &reel) == POINTREEL_ARGUMENT);
  EXPECT(pointreel_reel_open(reel_path, NULL, NULL) == POINTREEL_ARGUMENT);
  EXPECT(pointreel_reel_read(NULL, 0, NULL, &frame) == POINTREEL_ARGUMENT);
  EXPECT(pointreel_decode(NULL, 10, NULL, &frame) == POINTREEL_ARGUMENT);
  EXPECT(pointreel_decode("", 0, NULL, &frame) == POINTREEL_INVALID);
  EXPECT(pointreel_encode(NULL, NULL, &bytes) == POINTREEL_ARGUMENT && bytes == NULL);
  EXPECT(pointreel_writer_open(NULL, NULL, NULL, &writer) == POINTREEL_ARGUMENT);
  EXPECT(pointreel_writer_open("", NULL, NULL, &writer) == POINTREEL_ARGUMENT);
  EXPECT(pointreel_live_next(NULL, 0, NULL, &frame) == POINTREEL_ARGUMENT);
  EXPECT(pointreel_cancel(NULL) == POINTREEL_ARGUMENT);
  EXPECT(pointreel_frame_get_info(NULL, NULL) == POINTREEL_ARGUMENT);
  EXPECT(pointreel_frame_positions(NULL) == NULL);
  pointreel_reel_close(NULL);
  pointreel_frame_close(NULL);
  pointreel_bytes_close(NULL);
  pointreel_writer_close(NULL);
  pointreel_live_close(NULL);
  pointreel_canceller_close(NULL);

  reel = open_reel(reel_path);
  EXPECT(pointreel_reel_read(reel, kFrames, NULL, &frame) == POINTREEL_ARGUMENT);
  EXPECT(pointreel_reel_read(reel, UINT32_MAX, NULL, &frame) == POINTREEL_ARGUMENT);
  EXPECT(pointreel_reel_read((pointreel_reel*)(uintptr_t)0x1234567, 0, NULL, &frame) ==
         POINTREEL_ARGUMENT);
  EXPECT(pointreel_frame_get_info((const pointreel_frame*)reel, NULL) == POINTREEL_ARGUMENT);
  pointreel_read_options options = {0};
  EXPECT(pointreel_reel_read(reel, 0, &options, &frame) == POINTREEL_ARGUMENT);
  EXPECT(strstr(pointreel_error_message(), "struct_size") != NULL);
  options.struct_size = SIZE_MAX;
  EXPECT(pointreel_reel_read(reel, 0, &options, &frame) == POINTREEL_ARGUMENT);
  options.struct_size = sizeof options;
  options.max_memory = 1000;
  EXPECT(pointreel_reel_read(reel, 0, &options, &frame) == POINTREEL_LIMIT);

  TEST("structs of older and newer programs are read");
  struct {
    pointreel_read_options known;
    uint64_t more;
  } newer = {{0}, 0};
  newer.known.struct_size = sizeof newer;
  EXPECT(pointreel_reel_read(reel, 0, &newer.known, &frame) == POINTREEL_OK);
  float room[3];
  size_t count = 0;
  EXPECT(pointreel_frame_get_positions(frame, room, 1, &count) == POINTREEL_LIMIT);
  EXPECT(count == kPoints);
  EXPECT(pointreel_frame_get_positions(frame, NULL, 1, &count) == POINTREEL_ARGUMENT);
  EXPECT(pointreel_frame_get_positions(frame, NULL, 0, NULL) == POINTREEL_ARGUMENT);
  pointreel_frame_close(frame);
  EXPECT(pointreel_frame_get_positions(frame, room, 1, &count) == POINTREEL_ARGUMENT && count == 0);
  pointreel_frame_close(frame);
  newer.more = 1;
  EXPECT(pointreel_reel_read(reel, 0, &newer.known, &frame) == POINTREEL_UNSUPPORTED);
  pointreel_reel_info info;
  memset(&info, 0x55, sizeof info);
  info.struct_size = offsetof(pointreel_reel_info, duration_us);
  EXPECT(pointreel_reel_get_info(reel, &info) == POINTREEL_OK);
  EXPECT(info.frames == kFrames && info.duration_us == 0x5555555555555555u);
  pointreel_reel_close(reel);
  EXPECT(pointreel_reel_read(reel, 0, NULL, &frame) == POINTREEL_ARGUMENT);

  pointreel_points points = make_points(0);
  pointreel_encode_options encode = lossless();
  encode.codec = 7;
  EXPECT(pointreel_encode(&points, &encode, &bytes) == POINTREEL_ARGUMENT);
  encode = lossless();
  encode.depth = 22;
  EXPECT(pointreel_encode(&points, &encode, &bytes) == POINTREEL_ARGUMENT);
  encode = lossless();
  encode.color_quality = -1;
  EXPECT(pointreel_encode(&points, &encode, &bytes) == POINTREEL_ARGUMENT);
  encode = lossless();
  encode.voxel = NAN;
  EXPECT(pointreel_encode(&points, &encode, &bytes) == POINTREEL_ARGUMENT);
  points.count = (size_t)1 << 40;
  EXPECT(pointreel_encode(&points, NULL, &bytes) == POINTREEL_LIMIT);
  points = make_points(0);
  points.positions = NULL;
  EXPECT(pointreel_encode(&points, NULL, &bytes) == POINTREEL_ARGUMENT);
  points = make_points(0);
  points.origin[1] = INFINITY;
  EXPECT(pointreel_encode(&points, NULL, &bytes) == POINTREEL_ARGUMENT);
  points = make_points(0);
  for (int i = 0; i < kPoints; ++i) positions[i][0] = NAN;
  EXPECT(pointreel_encode(&points, NULL, &bytes) == POINTREEL_OK);
  EXPECT(pointreel_decode(pointreel_bytes_data(bytes), pointreel_bytes_size(bytes), NULL, &frame) ==
         POINTREEL_OK);
  EXPECT(count_of(frame) == 0 && pointreel_frame_positions(frame) == NULL);
  pointreel_frame_close(frame);
  pointreel_bytes_close(bytes);
}

/* --- Threads ---------------------------------------------------------------------------------- */

static pointreel_reel* shared_reel;
static atomic_int shared_reads;

static void* read_frames(void* argument) {
  const int first = *(const int*)argument;
  for (int i = 0; i < 20; ++i) {
    const int index = (first + i) % kFrames;
    pointreel_frame* frame = NULL;
    const pointreel_status status = pointreel_reel_read(shared_reel, (uint32_t)index, NULL, &frame);
    if (status == POINTREEL_ARGUMENT) return NULL; /* closed meanwhile */
    EXPECT(status == POINTREEL_OK);
    check_frame(frame, index);
    pointreel_frame_close(frame);
    ++shared_reads;
    /* The message of this thread is not touched by others. */
    char expected[64];
    snprintf(expected, sizeof expected, "there is no frame %d;", 1000 + first);
    EXPECT(pointreel_reel_read(shared_reel, (uint32_t)(1000 + first), NULL, &frame) ==
           POINTREEL_ARGUMENT);
    if (strstr(pointreel_error_message(), "closed") != NULL) return NULL;
    EXPECT(strstr(pointreel_error_message(), expected) != NULL);
  }
  return NULL;
}

static void threads_share_a_reel(int close_early) {
  TEST(close_early ? "a reel is closed while threads read" : "threads share a reel");
  shared_reel = open_reel(reel_path);
  shared_reads = 0;
  pthread_t threads[4];
  int firsts[4] = {0, 1, 2, 3};
  for (int i = 0; i < 4; ++i)
    EXPECT(pthread_create(&threads[i], NULL, read_frames, &firsts[i]) == 0);
  if (close_early) {
    while (shared_reads == 0) {
    }
    pointreel_reel_close(shared_reel);
  }
  for (int i = 0; i < 4; ++i) EXPECT(pthread_join(threads[i], NULL) == 0);
  if (!close_early) {
    EXPECT(shared_reads == 80);
    pointreel_reel_close(shared_reel);
  }
}

static pointreel_writer* shared_writer;

static void* add_frames(void* argument) {
  const pointreel_points* points = argument;
  for (int i = 0; i < 5; ++i)
    EXPECT(pointreel_writer_add(shared_writer, points, POINTREEL_BY_FPS) == POINTREEL_OK);
  return NULL;
}

static void threads_share_a_writer(void) {
  TEST("threads share a writer");
  char path[4200];
  snprintf(path, sizeof path, "%s.shared", reel_path);
  pointreel_write_options options = {0};
  options.struct_size = sizeof options;
  options.segment_frames = 4;
  EXPECT(pointreel_writer_open(path, &options, NULL, &shared_writer) == POINTREEL_OK);
  pointreel_points points = make_points(0);
  pthread_t threads[3];
  for (int i = 0; i < 3; ++i) EXPECT(pthread_create(&threads[i], NULL, add_frames, &points) == 0);
  for (int i = 0; i < 3; ++i) EXPECT(pthread_join(threads[i], NULL) == 0);
  EXPECT(pointreel_writer_finish(shared_writer) == POINTREEL_OK);
  pointreel_writer_close(shared_writer);
  pointreel_reel* reel = open_reel(path);
  pointreel_reel_info info = {0};
  info.struct_size = sizeof info;
  EXPECT(pointreel_reel_get_info(reel, &info) == POINTREEL_OK && info.frames == 15);
  pointreel_reel_close(reel);
}

static void* cancel_soon(void* canceller) {
  const struct timespec soon = {0, 50000000};
  nanosleep(&soon, NULL);
  EXPECT(pointreel_cancel(canceller) == POINTREEL_OK);
  return NULL;
}

static void another_thread_cancels(void) {
  TEST("another thread cancels what waits for a network");
  pointreel_canceller* canceller = NULL;
  EXPECT(pointreel_canceller_create(&canceller) == POINTREEL_OK);
  pointreel_open_options open = {0};
  open.struct_size = sizeof open;
  open.canceller = canceller;
  pointreel_live* live = NULL; /* nothing listens on this port */
  EXPECT(pointreel_live_open("ws://127.0.0.1:9/live/nobody", &open, &live) == POINTREEL_OK);
  pointreel_frame* frame = NULL;
  EXPECT(pointreel_live_next(live, 1, NULL, &frame) == POINTREEL_TIMEOUT);
  pthread_t thread;
  EXPECT(pthread_create(&thread, NULL, cancel_soon, canceller) == 0);
  EXPECT(pointreel_live_next(live, 3600000, NULL, &frame) == POINTREEL_CANCELLED);
  EXPECT(pthread_join(thread, NULL) == 0);
  pointreel_live_close(live);

  pointreel_reel* reel = NULL;
  EXPECT(pointreel_reel_open("http://127.0.0.1:9/reel", &open, &reel) == POINTREEL_CANCELLED);
  reel = open_reel(reel_path);
  pointreel_read_options read = {0};
  read.struct_size = sizeof read;
  read.canceller = canceller;
  EXPECT(pointreel_reel_read(reel, 0, &read, &frame) == POINTREEL_CANCELLED && frame == NULL);
  pointreel_canceller_close(canceller);
  EXPECT(pointreel_reel_read(reel, 0, &read, &frame) == POINTREEL_ARGUMENT);
  pointreel_reel_close(reel);
}

static void live_frames_are_read(const char* url) {
  TEST("live frames are read");
  pointreel_live* live = NULL;
  EXPECT(pointreel_live_open(url, NULL, &live) == POINTREEL_OK);
  for (int i = 0; i < 3; ++i) {
    pointreel_frame* frame = NULL;
    EXPECT(pointreel_live_next(live, 20000, NULL, &frame) == POINTREEL_OK);
    EXPECT(count_of(frame) > 0);
    pointreel_frame_info info = {0};
    info.struct_size = sizeof info;
    EXPECT(pointreel_frame_get_info(frame, &info) == POINTREEL_OK);
    EXPECT(info.time_us > 1000000000000000u); /* Unix time */
    pointreel_frame_close(frame);
  }
  char text[256];
  EXPECT(pointreel_live_get_trouble(live, text, sizeof text, NULL) == POINTREEL_OK);
  pointreel_live_close(live);
}

int main(int argc, char** argv) {
  if (argc != 2 && argc != 4) return 2;
  snprintf(reel_path, sizeof reel_path, "%s/reel", argv[1]);
  EXPECT(strcmp(pointreel_error_message(), "") == 0);
  EXPECT(pointreel_version()[0] != '\0');
  if (argc == 4) {
    frames_are_read_by_index_and_layers(argv[2]);
    live_frames_are_read(argv[3]);
    return 0;
  }
  scalar_fields_come_back_by_name();
  a_package_is_written_frame_by_frame();
  a_package_that_is_not_finished_is_absent();
  frames_are_read_by_index_and_layers(reel_path);
  frames_are_encoded_and_decoded();
  wrong_arguments_are_errors();
  threads_share_a_reel(0);
  threads_share_a_reel(1);
  threads_share_a_writer();
  another_thread_cancels();
  return 0;
}
