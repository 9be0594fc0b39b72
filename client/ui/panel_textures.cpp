#include "client/ui/panel_textures.h"

#include <array>
#include <memory>
#include <utility>

#include <backends/imgui_impl_opengl3.h>

namespace pointreel {
namespace {

/// Laid out like the framebuffers of most windows, blue first and the highest row first, so that
/// software OpenGL copies a panel byte by byte, in a tenth of the time of converting it. OpenGL has
/// no sized format for this.
gl::Texture make_window_like_texture(glm::ivec2 size) {
  gl::Texture texture = gl::Texture::create();
  glBindTexture(GL_TEXTURE_2D, texture.name());
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA, size.x, size.y, 0, GL_BGRA, GL_UNSIGNED_INT_8_8_8_8_REV,
               nullptr);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, 0);
  glBindTexture(GL_TEXTURE_2D, 0);
  return texture;
}

struct DeleteList {
  void operator()(ImDrawList* list) const { IM_DELETE(list); }
};

/// The same list, mirrored at y = middle.
std::unique_ptr<ImDrawList, DeleteList> upside_down(const ImDrawList& list, float middle) {
  std::unique_ptr<ImDrawList, DeleteList> turned(list.CloneOutput());
  for (ImDrawVert& vertex : turned->VtxBuffer) vertex.pos.y = 2.0f * middle - vertex.pos.y;
  for (ImDrawCmd& command : turned->CmdBuffer) {
    ImVec4& clip = command.ClipRect;
    clip = ImVec4(clip.x, 2.0f * middle - clip.w, clip.z, 2.0f * middle - clip.y);
  }
  return turned;
}

}  // namespace

bool PanelTextures::make(Panel& panel, glm::ivec2 size) {
  panel.texture = make_window_like_texture(size);
  auto framebuffer = gl::make_framebuffer(panel.texture);
  if (!framebuffer) return false;
  panel.framebuffer = *std::move(framebuffer);
  panel.size = size;
  panel.number = 0;
  return true;
}

bool PanelTextures::draw(const std::string& name, const ImDrawList& list, std::uint64_t number,
                         const ImDrawData& all, const Place& place, int height) {
  Panel& panel = panels_[name];
  panel.used = true;
  const bool same = panel.size == place.size && panel.number == number;
  if (panel.size != place.size && !make(panel, place.size)) return false;
  if (!same) {
    const ImVec2 scale = all.FramebufferScale;
    ImDrawData part;
    part.DisplayPos = ImVec2(all.DisplayPos.x + static_cast<float>(place.corner.x) / scale.x,
                             all.DisplayPos.y + static_cast<float>(place.corner.y) / scale.y);
    part.DisplaySize = ImVec2(static_cast<float>(place.size.x) / scale.x,
                              static_cast<float>(place.size.y) / scale.y);
    part.FramebufferScale = scale;
    const auto turned = upside_down(list, part.DisplayPos.y + 0.5f * part.DisplaySize.y);
    ImDrawList* const only = turned.get();
    part.CmdLists = const_cast<ImDrawList**>(&only);
    part.CmdListsCount = 1;
    part.TotalVtxCount = turned->VtxBuffer.Size;
    part.TotalIdxCount = turned->IdxBuffer.Size;
    part.Valid = true;
    const ImVec4& ground = ImGui::GetStyle().Colors[ImGuiCol_WindowBg];
    const std::array<GLfloat, 4> color = {ground.x, ground.y, ground.z, 1.0f};
    glBindFramebuffer(GL_FRAMEBUFFER, panel.framebuffer.name());
    glDisable(GL_SCISSOR_TEST);
    glClearNamedFramebufferfv(panel.framebuffer.name(), GL_COLOR, 0, color.data());
    ImGui_ImplOpenGL3_RenderDrawData(&part);
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    panel.number = number;
  }
  glDisable(GL_SCISSOR_TEST);
  const int top = height - place.corner.y;
  glBlitNamedFramebuffer(panel.framebuffer.name(), 0, 0, 0, place.size.x, place.size.y,
                         place.corner.x, top, place.corner.x + place.size.x, top - place.size.y,
                         GL_COLOR_BUFFER_BIT, GL_NEAREST);
  return true;
}

void PanelTextures::forget_unused() {
  std::erase_if(panels_, [](const auto& entry) { return !entry.second.used; });
  for (auto& entry : panels_) entry.second.used = false;
}

}  // namespace pointreel
