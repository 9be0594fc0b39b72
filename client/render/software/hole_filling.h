#pragma once

#include <utility>
#include <vector>

#include <glm/glm.hpp>

#include "client/render/software/picture.h"
#include "client/render/view.h"
#include "pointreel/executor.h"

namespace pointreel {

/// Fills the holes of splatted surfaces by pull and push, by the same rules as the OpenGL renderer
/// (opengl/reconstruction.h; FORMULAS.md, "Hole filling").
class HoleFilling {
 public:
  /// If the signs of normals are unknown: marks pixels that show a farther surface through a hole
  /// of a nearer one as not drawn. `radius` is that of a typical surfel, and `nearest` a depth that
  /// no surfel is in front of, > 0.
  static void clear_see_through(const PictureView& view, float radius, float nearest,
                                const Executor& executor, Picture& picture);

  /// Finds the colours of holes in `picture`. `pixels` is the radius of a typical surfel in pixels.
  void find(const Picture& picture, float pixels, const Executor& executor);
  /// Writes them. The depths are those that `find` saw.
  void fill(const Executor& executor, Picture& picture) const;

 private:
  /// Mean colours of squares of the picture (rgb, linear), multiplied by the share of the square
  /// that is covered (a).
  struct Level {
    glm::ivec2 size{0};
    std::vector<glm::vec4> texels;

    void resize(glm::ivec2 texels_in);
    const glm::vec4& at(int x, int y) const {
      return texels[static_cast<std::size_t>(y) * static_cast<std::size_t>(size.x) +
                    static_cast<std::size_t>(x)];
    }
    glm::vec4& at(int x, int y) { return const_cast<glm::vec4&>(std::as_const(*this).at(x, y)); }
    /// Bilinear, in texels; the middle of the first texel is 0.5.
    glm::vec4 sample(const glm::vec2& place) const;
  };

  bool is_hole(const Picture& picture, int x, int y) const;

  /// Finest first; the coarsest level is not pushed. Pushed colours are multiplied by the largest
  /// share that is covered of any square around.
  std::vector<Level> pulled_, pushed_;
  std::size_t crowd_ = 0;  ///< the level that tells how much around a pixel is covered
  int crowd_edge_ = 1;     ///< edge of its squares in pixels
};

}  // namespace pointreel
