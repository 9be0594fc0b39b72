#include <algorithm>
#include <array>
#include <optional>
#include <utility>
#include <vector>

#include "client/render/instancing/methods.h"
#include "client/render/instancing/pass_programs.h"

namespace pointreel {
namespace {

/// So many are listed at a time: their elements fit into the smallest buffer that drivers promise.
constexpr std::size_t kBatch = std::size_t{1} << 20;
constexpr std::size_t kElementBytes = 64;  ///< of the largest Element
constexpr std::size_t kWordBytes = 8, kInstancesPerWord = 32;
constexpr std::size_t kCommandBytes = 20;
constexpr GLuint kGroup = 64;

enum Binding : GLuint { kInstances, kWords, kCommand, kElements };
enum Location : GLint { kInstanceCount = 2, kLargestScale = 3, kIndicesPerInstance = 4 };

struct ListPrograms {
  gl::Program mark, count, write;
};

/// The triangles of an element, as indices of its vertices.
std::vector<GLuint> triangles(Pass pass) {
  const PassTemplate shape = pass_template(pass);
  std::vector<GLuint> indices;
  for (GLuint i = 2; i < static_cast<GLuint>(shape.vertices); ++i) {
    if (shape.topology == GL_TRIANGLE_FAN) {
      indices.insert(indices.end(), {0, i - 1, i});
    } else if (i % 2 == 0) {
      indices.insert(indices.end(), {i - 2, i - 1, i});
    } else {
      indices.insert(indices.end(), {i - 1, i - 2, i});
    }
  }
  return indices;
}

/// The same triangles for element after element.
struct IndexBuffer {
  gl::Buffer buffer;
  std::size_t elements = 0;
  GLuint per_element = 0;

  void reserve(Pass pass, std::size_t wanted) {
    if (wanted <= elements) return;
    elements = std::min(kBatch, wanted + wanted / 4);
    const std::vector<GLuint> one = triangles(pass);
    per_element = static_cast<GLuint>(one.size());
    const auto vertices = static_cast<GLuint>(pass_template(pass).vertices);
    std::vector<GLuint> all;
    all.reserve(elements * one.size());
    for (std::size_t e = 0; e < elements; ++e)
      for (const GLuint index : one) all.push_back(static_cast<GLuint>(e) * vertices + index);
    buffer = gl::Buffer::create();
    glNamedBufferStorage(buffer.name(), static_cast<GLsizeiptr>(all.size() * sizeof(GLuint)),
                         all.data(), 0);
  }
};

/// Neither surfels that show their back nor any outside of the picture become vertices: three
/// compute shaders list the others, placed, and the passes draw that list as one indexed mesh,
/// whose vertex shader has next to nothing left to do.
class PullInstancing final : public InstancingMethod {
 public:
  PullInstancing(PassPrograms programs, ListPrograms surfels, ListPrograms voxels)
      : programs_(std::move(programs)), surfels_(std::move(surfels)), voxels_(std::move(voxels)) {
    glNamedBufferStorage(command_.name(), kCommandBytes, nullptr, 0);
  }

  void begin(float largest_scale) override {
    listed_.reset();
    glProgramUniform1f(surfels_.mark.name(), kLargestScale, largest_scale);
  }

  void draw(const InstanceBuffer& instances, Pass pass, const PassParameters& parameters) override {
    for (std::size_t first = 0; first < instances.size(); first += kBatch) {
      const std::size_t count = std::min(kBatch, instances.size() - first);
      IndexBuffer& indices = indices_[static_cast<std::size_t>(pass)];
      indices.reserve(pass, count);
      list(instances, pass, first, count, indices.per_element);
      programs_.use(pass, parameters);
      glVertexArrayElementBuffer(no_attributes_.name(), indices.buffer.name());
      glBindVertexArray(no_attributes_.name());
      glBindBuffer(GL_DRAW_INDIRECT_BUFFER, command_.name());
      glDrawElementsIndirect(GL_TRIANGLES, GL_UNSIGNED_INT, nullptr);
    }
  }

 private:
  /// What the list was made for. The passes of one picture share it.
  struct Listed {
    std::size_t first;
    bool surfels;
    GLuint indices;
    bool operator==(const Listed&) const = default;
  };

  void list(const InstanceBuffer& instances, Pass pass, std::size_t first, std::size_t count,
            GLuint indices) {
    const Listed wanted{first, is_surfel(pass), indices};
    if (listed_ == wanted) return;
    listed_ = wanted;
    const std::size_t words = (count + kInstancesPerWord - 1) / kInstancesPerWord;
    reserve(count);
    glBindBufferRange(GL_SHADER_STORAGE_BUFFER, kInstances, instances.name(),
                      instances.offset() + static_cast<GLintptr>(first * sizeof(Instance)),
                      static_cast<GLsizeiptr>(count * sizeof(Instance)));
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kWords, words_.name());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kCommand, command_.name());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kElements, elements_.name());
    const ListPrograms& programs = wanted.surfels ? surfels_ : voxels_;
    run(programs.mark, count, words);
    glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
    glProgramUniform1ui(programs.count.name(), kIndicesPerInstance, indices);
    run(programs.count, count, 1);
    glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
    run(programs.write, count, count);
    glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_COMMAND_BARRIER_BIT);
  }

  static void run(const gl::Program& program, std::size_t count, std::size_t invocations) {
    glProgramUniform1ui(program.name(), kInstanceCount, static_cast<GLuint>(count));
    glUseProgram(program.name());
    glDispatchCompute((static_cast<GLuint>(invocations) + kGroup - 1) / kGroup, 1, 1);
  }

  void reserve(std::size_t count) {
    if (count <= capacity_) return;
    capacity_ = std::min(kBatch, count + count / 4 + kInstancesPerWord);
    const auto make = [](std::size_t bytes) {
      gl::Buffer buffer = gl::Buffer::create();
      glNamedBufferStorage(buffer.name(), static_cast<GLsizeiptr>(bytes), nullptr, 0);
      return buffer;
    };
    words_ = make((capacity_ / kInstancesPerWord + 1) * kWordBytes);
    elements_ = make(capacity_ * kElementBytes);
  }

  PassPrograms programs_;
  ListPrograms surfels_, voxels_;
  gl::Buffer words_, elements_, command_ = gl::Buffer::create();
  std::size_t capacity_ = 0;
  std::array<IndexBuffer, 5> indices_;
  gl::VertexArray no_attributes_ = gl::VertexArray::create();
  std::optional<Listed> listed_;
};

Result<ListPrograms> make_list_programs(bool surfel) {
  const auto make = [surfel](std::vector<std::string_view> own) {
    std::vector<std::string_view> files = placing_files(surfel);
    files.insert(files.end(), own.begin(), own.end());
    return gl::make_program(std::array{gl::Stage{GL_COMPUTE_SHADER, std::move(files)}});
  };
  auto mark =
      make({"instancing/pull/mark.glsl",
            surfel ? "instancing/pull/surfel_visible.glsl" : "instancing/pull/voxel_visible.glsl",
            "instancing/pull/list.glsl", "instancing/pull/mark.comp.glsl"});
  if (!mark) return fail(mark.error().message);
  auto count = make({"instancing/pull/list.glsl", "instancing/pull/count.comp.glsl"});
  if (!count) return fail(count.error().message);
  auto write = make({"instancing/pull/list.glsl", "instancing/pull/write.comp.glsl"});
  if (!write) return fail(write.error().message);
  return ListPrograms{std::move(*mark), std::move(*count), std::move(*write)};
}

}  // namespace

Result<std::unique_ptr<InstancingMethod>> make_pull_instancing() {
  auto programs = PassPrograms::create([](Pass, std::vector<std::string_view> primitive) {
    primitive.push_back("instancing/pull/pull.vert.glsl");
    return std::vector<gl::Stage>{{GL_VERTEX_SHADER, std::move(primitive)}};
  });
  if (!programs) return fail(programs.error().message);
  auto surfels = make_list_programs(true);
  if (!surfels) return fail(surfels.error().message);
  auto voxels = make_list_programs(false);
  if (!voxels) return fail(voxels.error().message);
  return std::make_unique<PullInstancing>(std::move(*programs), std::move(*surfels),
                                          std::move(*voxels));
}

}  // namespace pointreel
