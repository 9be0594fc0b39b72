/* Prints when each frame of a reel is shown, and how many points it has.
 *
 *   list REEL */
#include <pointreel.h>
#include <stdio.h>

int main(int argc, char** argv) {
  if (argc != 2) {
    fprintf(stderr, "list: give the folder or address of a reel\n");
    return 2;
  }
  pointreel_reel* reel = NULL;
  pointreel_reel_info info = {.struct_size = sizeof info};
  if (pointreel_reel_open(argv[1], NULL, &reel) != POINTREEL_OK ||
      pointreel_reel_get_info(reel, &info) != POINTREEL_OK) {
    fprintf(stderr, "list: %s\n", pointreel_error_message());
    return 1;
  }
  for (uint32_t i = 0; i < info.frames; ++i) {
    pointreel_frame* frame = NULL;
    pointreel_frame_info about = {.struct_size = sizeof about};
    if (pointreel_reel_read(reel, i, NULL, &frame) != POINTREEL_OK ||
        pointreel_frame_get_info(frame, &about) != POINTREEL_OK) {
      fprintf(stderr, "list: %s\n", pointreel_error_message()); /* and go on with the next */
      continue;
    }
    printf("%8.3f s  %llu points\n", 1e-6 * (double)about.time_us,
           (unsigned long long)about.points);
    pointreel_frame_close(frame);
  }
  pointreel_reel_close(reel);
  return 0;
}
