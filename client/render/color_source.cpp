#include "client/render/color_source.h"

namespace pointreel {

const char* name(ColorSource source) {
  switch (source) {
    case ColorSource::colors:
      return "colors";
    case ColorSource::normals:
      return "normals";
    case ColorSource::plain:
      return "plain";
  }
  return "";
}

}  // namespace pointreel
