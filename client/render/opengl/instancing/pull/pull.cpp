#include <algorithm>
#include <array>
#include <optional>
#include <utility>
#include <vector>

#include "client/render/opengl/instancing/methods.h"
#include "client/render/opengl/instancing/pass_programs.h"
#include "common/base/try.h"

namespace pointreel {
namespace {

/// The most instances that are listed at a time. Their elements fit into the smallest storage
/// buffer that a driver must support.
constexpr std::size_t kMaxBatch = std::size_t{1} << 20;
constexpr std::size_t kTexelsPerSprite = 3;  ///< more than an instance has
/// Batches begin at multiples of 64 KiB, where texture buffers may begin on every driver.
constexpr std::size_t kBatchGranule = 65536 / sizeof(Instance);
constexpr std::size_t kSpriteBytes = 48, kElementBytes = 64;  ///< sizes of the shaders' structures
constexpr std::size_t kWordBytes = 16, kInstancesPerWord = 32;
constexpr GLuint kGroup = 64;

/// Size of a command of glDrawArraysIndirect. There are two, for sprites and then for solids
/// (count.comp.glsl).
constexpr std::size_t kCommandBytes = 16;

enum Binding : GLuint { kWords = 1, kCommands, kSprites, kSolids };
enum Location : GLint { kInstanceCount = 2, kLargestScale = 3, kVerticesPerSolid = 4 };

struct ListPrograms {
  gl::LateProgram mark, count, write;
};

/// Three compute shaders list the instances that are visible, and the passes draw that list.
/// Surfels that show their back and everything outside of the picture never become vertices. An
/// instance that a GL point can cover (a sprite) takes one vertex, instead of four vertices and two
/// triangles for a surfel or eight and six for a voxel. The others are solids.
class PullInstancing final : public InstancingMethod {
 public:
  PullInstancing();

  void begin(float largest_scale) override {
    listed_.reset();
    largest_scale_ = largest_scale;
  }

  Result<void> draw(const InstanceBuffer& instances, Pass pass,
                    const PassParameters& parameters) override {
    for (std::size_t first = 0; first < instances.size(); first += batch_) {
      const std::size_t count = std::min(batch_, instances.size() - first);
      TRY(list(instances, pass, first, count));
      glBindVertexArray(no_attributes_.name());
      glBindBuffer(GL_DRAW_INDIRECT_BUFFER, commands_.name());
      TRY(use_program(sprites_of_[static_cast<std::size_t>(pass)], pass, parameters));
      glBindTextureUnit(0, sprite_texture_.name());
      glEnable(GL_PROGRAM_POINT_SIZE);
      glDrawArraysIndirect(GL_POINTS, nullptr);
      TRY(solids_of_.use(pass, parameters));
      glDrawArraysIndirect(GL_TRIANGLES, reinterpret_cast<const void*>(kCommandBytes));
    }
    return {};
  }

 private:
  /// What the list was made for. The passes of a picture share the list.
  struct Listed {
    std::size_t first;  ///< instance of the batch
    GLuint vertices;    ///< per solid
    bool operator==(const Listed&) const = default;
  };

  Result<void> list(const InstanceBuffer& instances, Pass pass, std::size_t first,
                    std::size_t count) {
    const Listed wanted{first, 3 * static_cast<GLuint>(pass_template(pass).vertices - 2)};
    if (listed_ == wanted) return {};
    const std::size_t words = (count + kInstancesPerWord - 1) / kInstancesPerWord;
    reserve(count);
    glTextureBufferRange(instance_texture_.name(), GL_RGBA32UI, instances.name(),
                         static_cast<GLintptr>(first * sizeof(Instance)),
                         static_cast<GLsizeiptr>(count * sizeof(Instance)));
    glBindTextureUnit(0, instance_texture_.name());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kWords, words_.name());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kCommands, commands_.name());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kSprites, sprites_.name());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kSolids, solids_.name());
    ListPrograms& programs = is_surfel(pass) ? list_surfels_ : list_voxels_;
    TRY(use(programs.mark, count));
    glUniform1f(kLargestScale, largest_scale_);
    run(words);
    glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
    TRY(use(programs.count, count));
    glUniform1ui(kVerticesPerSolid, wanted.vertices);
    run(1);
    glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
    TRY(use(programs.write, count));
    run(count);
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_SHADER_STORAGE_BARRIER_BIT |
                    GL_COMMAND_BARRIER_BIT);
    listed_ = wanted;
    return {};
  }

  static Result<void> use(gl::LateProgram& step, std::size_t count) {
    TRY(step.use());
    glUniform1ui(kInstanceCount, static_cast<GLuint>(count));
    return {};
  }

  static void run(std::size_t invocations) {
    glDispatchCompute((static_cast<GLuint>(invocations) + kGroup - 1) / kGroup, 1, 1);
  }

  void reserve(std::size_t count) {
    if (count <= capacity_) return;
    capacity_ = std::min(batch_, count + count / 4);
    const auto make = [](std::size_t bytes) {
      gl::Buffer buffer = gl::Buffer::create();
      glNamedBufferStorage(buffer.name(), static_cast<GLsizeiptr>(bytes), nullptr, 0);
      return buffer;
    };
    words_ = make((capacity_ / kInstancesPerWord + 1) * kWordBytes);
    sprites_ = make(capacity_ * kSpriteBytes);
    glTextureBuffer(sprite_texture_.name(), GL_RGBA32UI, sprites_.name());
    solids_ = make(capacity_ * kElementBytes);
  }

  PassPrograms solids_of_;
  std::array<gl::LateProgram, kPasses> sprites_of_;
  ListPrograms list_surfels_, list_voxels_;
  float largest_scale_ = 1.0f;
  gl::Buffer words_, sprites_, solids_, commands_ = gl::Buffer::create();
  gl::BufferTexture instance_texture_ = gl::BufferTexture::create();
  gl::BufferTexture sprite_texture_ = gl::BufferTexture::create();
  std::size_t batch_ = 0;     ///< the most instances of a list
  std::size_t capacity_ = 0;  ///< number of instances for which the buffers have room
  gl::VertexArray no_attributes_ = gl::VertexArray::create();
  std::optional<Listed> listed_;
};

ListPrograms list_programs(bool surfel) {
  const std::string_view sprite =
      surfel ? "instancing/pull/surfel_sprite.glsl" : "instancing/pull/voxel_sprite.glsl";
  const auto program = [surfel, sprite](std::vector<std::string_view> own) {
    std::vector<std::string_view> files = placing_files(surfel);
    files.insert(files.end(), {sprite, "instancing/pull/list.glsl"});
    files.insert(files.end(), own.begin(), own.end());
    return gl::LateProgram({{GL_COMPUTE_SHADER, std::move(files)}});
  };
  return {program({"instancing/pull/mark.glsl",
                   surfel ? "instancing/pull/surfel_mark.glsl" : "instancing/pull/voxel_mark.glsl",
                   "instancing/pull/mark.comp.glsl"}),
          program({"instancing/pull/count.comp.glsl"}),
          program({"instancing/pull/write.comp.glsl"})};
}

gl::LateProgram sprite_program(Pass pass) {
  std::vector<std::string_view> vertex = placing_files(is_surfel(pass)), fragment;
  if (is_surfel(pass)) {
    vertex.insert(vertex.end(),
                  {"instancing/pull/surfel_sprite.glsl", "instancing/pull/listed_surfel.glsl",
                   "instancing/pull/surfel_sprite.vert.glsl"});
    fragment = fragment_files(pass, "instancing/pull/sprite_footprint.glsl");
  } else {
    vertex.insert(vertex.end(),
                  {"instancing/pull/voxel_sprite.glsl", "instancing/pull/listed_voxel.glsl",
                   "instancing/pull/voxel_sprite.vert.glsl"});
    fragment = {"instancing/pull/voxel_sprite.frag.glsl"};
  }
  return gl::LateProgram(
      {{GL_VERTEX_SHADER, std::move(vertex)}, {GL_FRAGMENT_SHADER, std::move(fragment)}});
}

std::vector<gl::Stage> solid_stages(Pass, std::vector<std::string_view> primitive) {
  primitive.push_back("instancing/shaders/separate_triangles.glsl");
  primitive.push_back("instancing/pull/solid.vert.glsl");
  return {{GL_VERTEX_SHADER, std::move(primitive)}};
}

PullInstancing::PullInstancing()
    : solids_of_(solid_stages),
      list_surfels_(list_programs(true)),
      list_voxels_(list_programs(false)) {
  for (std::size_t i = 0; i < kPasses; ++i) sprites_of_[i] = sprite_program(static_cast<Pass>(i));
  glNamedBufferStorage(commands_.name(), 2 * kCommandBytes, nullptr, 0);
  GLint texels = 0;
  glGetIntegerv(GL_MAX_TEXTURE_BUFFER_SIZE, &texels);
  batch_ = std::min(kMaxBatch, static_cast<std::size_t>(texels) / kTexelsPerSprite / kBatchGranule *
                                   kBatchGranule);
}

}  // namespace

std::unique_ptr<InstancingMethod> make_pull_instancing() {
  return std::make_unique<PullInstancing>();
}

}  // namespace pointreel
