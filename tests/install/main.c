/* The same in C, by the library that is installed for it. */
#include <pointreel.h>
#include <stdio.h>

int main(void) {
  static float positions[1000][3];
  for (int i = 0; i < 1000; ++i) {
    positions[i][0] = (float)(i % 10);
    positions[i][1] = (float)(i / 10 % 10);
    positions[i][2] = (float)(i / 100);
  }
  pointreel_points points = {0};
  points.struct_size = sizeof points;
  points.count = 1000;
  points.positions = &positions[0][0];
  pointreel_bytes* bytes = NULL;
  pointreel_frame* frame = NULL;
  size_t count = 0;
  if (pointreel_encode(&points, NULL, &bytes) != POINTREEL_OK ||
      pointreel_decode(pointreel_bytes_data(bytes), pointreel_bytes_size(bytes), NULL, &frame) !=
          POINTREEL_OK ||
      pointreel_frame_get_positions(frame, NULL, 0, &count) != POINTREEL_OK) {
    printf("failed: %s\n", pointreel_error_message());
    return 1;
  }
  printf("%zu of 1000 points in %zu bytes\n", count, pointreel_bytes_size(bytes));
  pointreel_frame_close(frame);
  pointreel_bytes_close(bytes);
  return count == 1000 ? 0 : 1;
}
