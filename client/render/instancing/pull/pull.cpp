#include <algorithm>
#include <array>
#include <optional>
#include <utility>
#include <vector>

#include "client/render/instancing/methods.h"
#include "client/render/instancing/pass_programs.h"

namespace pointreel {
namespace {

/// No more are listed at a time: their elements fit into the smallest buffer that drivers promise.
constexpr std::size_t kMaxBatch = std::size_t{1} << 20;
constexpr std::size_t kTexelsPerSprite = 3;  ///< an instance has fewer
/// Where in the instances a batch may begin: at multiples of 64 KiB.
constexpr std::size_t kBatchGranule = 2048;
constexpr std::size_t kSpriteBytes = 48, kElementBytes = 64;  ///< as the shaders declare them
constexpr std::size_t kWordBytes = 16, kInstancesPerWord = 32;
constexpr GLuint kGroup = 64;

/// glDrawArraysIndirect's; sprites', then solids' (count.comp.glsl).
constexpr std::size_t kCommandBytes = 16;

enum Binding : GLuint { kWords = 1, kCommands, kSprites, kSolids };
enum Location : GLint { kInstanceCount = 2, kLargestScale = 3, kVerticesPerSolid = 4 };

struct ListPrograms {
  gl::Program mark, count, write;
};

/// Neither surfels that show their back nor any outside of the picture become vertices: three
/// compute shaders list the others, and the passes draw that list. What a point can cover is drawn
/// as one, which spares four vertices and two triangles, or eight and six.
class PullInstancing final : public InstancingMethod {
 public:
  struct Programs {
    PassPrograms solids;
    std::array<gl::Program, kPasses> sprites;
    ListPrograms list_surfels, list_voxels;
  };

  explicit PullInstancing(Programs programs) : programs_(std::move(programs)) {
    glNamedBufferStorage(commands_.name(), 2 * kCommandBytes, nullptr, 0);
    GLint texels = 0;
    glGetIntegerv(GL_MAX_TEXTURE_BUFFER_SIZE, &texels);
    batch_ = std::min(kMaxBatch, static_cast<std::size_t>(texels) / kTexelsPerSprite /
                                     kBatchGranule * kBatchGranule);
  }

  void begin(float largest_scale) override {
    listed_.reset();
    glProgramUniform1f(programs_.list_surfels.mark.name(), kLargestScale, largest_scale);
  }

  void draw(const InstanceBuffer& instances, Pass pass, const PassParameters& parameters) override {
    for (std::size_t first = 0; first < instances.size(); first += batch_) {
      const std::size_t count = std::min(batch_, instances.size() - first);
      list(instances, pass, first, count);
      glBindVertexArray(no_attributes_.name());
      glBindBuffer(GL_DRAW_INDIRECT_BUFFER, commands_.name());
      use_program(programs_.sprites[static_cast<std::size_t>(pass)], pass, parameters);
      glBindTextureUnit(0, sprite_texture_.name());
      glEnable(GL_PROGRAM_POINT_SIZE);
      glDrawArraysIndirect(GL_POINTS, nullptr);
      programs_.solids.use(pass, parameters);
      glDrawArraysIndirect(GL_TRIANGLES, reinterpret_cast<const void*>(kCommandBytes));
    }
  }

 private:
  /// What the list was made for. The passes of one picture share it.
  struct Listed {
    std::size_t first;
    GLuint vertices;  ///< of a solid
    bool operator==(const Listed&) const = default;
  };

  void list(const InstanceBuffer& instances, Pass pass, std::size_t first, std::size_t count) {
    const Listed wanted{first, 3 * static_cast<GLuint>(pass_template(pass).vertices - 2)};
    if (listed_ == wanted) return;
    listed_ = wanted;
    const std::size_t words = (count + kInstancesPerWord - 1) / kInstancesPerWord;
    reserve(count);
    glTextureBufferRange(instance_texture_.name(), GL_RGBA32UI, instances.name(),
                         instances.offset() + static_cast<GLintptr>(first * sizeof(Instance)),
                         static_cast<GLsizeiptr>(count * sizeof(Instance)));
    glBindTextureUnit(0, instance_texture_.name());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kWords, words_.name());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kCommands, commands_.name());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kSprites, sprites_.name());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kSolids, solids_.name());
    const ListPrograms& programs = is_surfel(pass) ? programs_.list_surfels : programs_.list_voxels;
    run(programs.mark, count, words);
    glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
    glProgramUniform1ui(programs.count.name(), kVerticesPerSolid, wanted.vertices);
    run(programs.count, count, 1);
    glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
    run(programs.write, count, count);
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_SHADER_STORAGE_BARRIER_BIT |
                    GL_COMMAND_BARRIER_BIT);
  }

  static void run(const gl::Program& program, std::size_t count, std::size_t invocations) {
    glProgramUniform1ui(program.name(), kInstanceCount, static_cast<GLuint>(count));
    glUseProgram(program.name());
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

  Programs programs_;
  gl::Buffer words_, sprites_, solids_, commands_ = gl::Buffer::create();
  gl::BufferTexture instance_texture_ = gl::BufferTexture::create();
  gl::BufferTexture sprite_texture_ = gl::BufferTexture::create();
  std::size_t batch_ = 0;
  std::size_t capacity_ = 0;
  gl::VertexArray no_attributes_ = gl::VertexArray::create();
  std::optional<Listed> listed_;
};

Result<ListPrograms> make_list_programs(bool surfel) {
  const std::string_view sprite =
      surfel ? "instancing/pull/surfel_sprite.glsl" : "instancing/pull/voxel_sprite.glsl";
  const auto make = [surfel, sprite](std::vector<std::string_view> own) {
    std::vector<std::string_view> files = placing_files(surfel);
    files.insert(files.end(), {sprite, "instancing/pull/list.glsl"});
    files.insert(files.end(), own.begin(), own.end());
    return gl::make_program(std::array{gl::Stage{GL_COMPUTE_SHADER, std::move(files)}});
  };
  auto mark = make({"instancing/pull/mark.glsl",
                    surfel ? "instancing/pull/surfel_mark.glsl" : "instancing/pull/voxel_mark.glsl",
                    "instancing/pull/mark.comp.glsl"});
  if (!mark) return fail(mark.error().message);
  auto count = make({"instancing/pull/count.comp.glsl"});
  if (!count) return fail(count.error().message);
  auto write = make({"instancing/pull/write.comp.glsl"});
  if (!write) return fail(write.error().message);
  return ListPrograms{std::move(*mark), std::move(*count), std::move(*write)};
}

Result<gl::Program> make_sprite_program(Pass pass) {
  std::vector<std::string_view> vertex = placing_files(is_surfel(pass));
  if (!is_surfel(pass)) {
    vertex.insert(vertex.end(),
                  {"instancing/pull/voxel_sprite.glsl", "instancing/pull/voxel_sprite.vert.glsl"});
    return gl::make_program(
        std::array{gl::Stage{GL_VERTEX_SHADER, std::move(vertex)},
                   gl::Stage{GL_FRAGMENT_SHADER, {"instancing/pull/voxel_sprite.frag.glsl"}}});
  }
  vertex.insert(vertex.end(),
                {"instancing/pull/surfel_sprite.glsl", "instancing/pull/surfel_sprite.vert.glsl"});
  return gl::make_program(
      std::array{gl::Stage{GL_VERTEX_SHADER, std::move(vertex)},
                 gl::Stage{GL_FRAGMENT_SHADER,
                           fragment_files(pass, "instancing/pull/sprite_footprint.glsl")}});
}

}  // namespace

Result<std::unique_ptr<InstancingMethod>> make_pull_instancing() {
  PullInstancing::Programs programs;
  auto solids = PassPrograms::create([](Pass, std::vector<std::string_view> primitive) {
    primitive.push_back("instancing/pull/solid.vert.glsl");
    return std::vector<gl::Stage>{{GL_VERTEX_SHADER, std::move(primitive)}};
  });
  if (!solids) return fail(solids.error().message);
  programs.solids = std::move(*solids);
  for (std::size_t i = 0; i < kPasses; ++i) {
    auto program = make_sprite_program(static_cast<Pass>(i));
    if (!program) return fail(program.error().message);
    programs.sprites[i] = std::move(*program);
  }
  auto surfels = make_list_programs(true);
  if (!surfels) return fail(surfels.error().message);
  auto voxels = make_list_programs(false);
  if (!voxels) return fail(voxels.error().message);
  programs.list_surfels = std::move(*surfels);
  programs.list_voxels = std::move(*voxels);
  return std::make_unique<PullInstancing>(std::move(programs));
}

}  // namespace pointreel
