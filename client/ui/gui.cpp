#include "client/ui/gui.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <iterator>
#include <utility>

#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <epoxy/gl.h>
#include <imgui.h>
#include <imgui_internal.h>
#define XXH_INLINE_ALL
#include <xxhash.h>

#include "client/ui/panel.h"

namespace pointreel {
namespace {

constexpr const char* kFont = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf";
constexpr float kFontSize = 14.0f;

/// Latin, Greek and Cyrillic, because file names are shown.
constexpr std::array<ImWchar, 7> kGlyphs = {0x0020, 0x024f, 0x0370, 0x052f, 0x2010, 0x2044, 0};

void add_font(float scale) {
  ImFontAtlas& fonts = *ImGui::GetIO().Fonts;
  if (std::filesystem::exists(kFont)) {
    // Glyphs lie on whole pixels, as sample_nearest needs.
    ImFontConfig config;
    config.OversampleH = 1;
    config.PixelSnapH = true;
    fonts.AddFontFromFileTTF(kFont, std::round(kFontSize * scale), &config, kGlyphs.data());
  } else {
    ImFontConfig config;
    config.SizePixels = 13.0f * scale;
    fonts.AddFontDefault(&config);
  }
}

/// Turns off interpolation in the font texture, which everything but pictures is drawn with and
/// which is never scaled. With software OpenGL this halves the time to draw the interface.
void sample_nearest() {
  const auto font =
      static_cast<GLuint>(reinterpret_cast<std::uintptr_t>(ImGui::GetIO().Fonts->TexID));
  glBindTexture(GL_TEXTURE_2D, font);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
}

void set_style(float scale) {
  ImGuiStyle& style = ImGui::GetStyle();
  style = ImGuiStyle();
  ImGui::StyleColorsDark();
  style.WindowRounding = style.FrameRounding = style.GrabRounding = 4.0f;
  style.WindowBorderSize = 0.0f;
  style.Colors[ImGuiCol_WindowBg] = {0.07f, 0.075f, 0.085f, 1.0f};
  style.Colors[ImGuiCol_TitleBg] =
      style.Colors[ImGuiCol_TitleBgActive] = {0.12f, 0.13f, 0.15f, 0.95f};
  style.ScaleAllSizes(scale);
}

template <class T>
std::uint64_t checksum(const ImVector<T>& values, std::uint64_t seed) {
  return XXH3_64bits_withSeed(values.Data, static_cast<std::size_t>(values.size_in_bytes()), seed);
}

/// A checksum of everything that the list draws.
std::uint64_t checksum(const ImDrawList& list) {
  std::uint64_t number = checksum(list.VtxBuffer, checksum(list.IdxBuffer, 0));
  for (const ImDrawCmd& command : list.CmdBuffer) {
    number = XXH3_64bits_withSeed(&command.ClipRect, sizeof(command.ClipRect), number);
    number = XXH3_64bits_withSeed(&command.TextureId, sizeof(command.TextureId), number);
    number = XXH3_64bits_withSeed(&command.ElemCount, sizeof(command.ElemCount), number);
  }
  return number;
}

/// The pixels of the framebuffer that the window covers.
PanelTextures::Place place_of(const ImGuiWindow& window, const ImDrawData& all) {
  const auto pixels = [](const ImVec2& at, const ImVec2& scale) {
    return glm::ivec2(glm::round(glm::vec2(at.x * scale.x, at.y * scale.y)));
  };
  const ImVec2& from = all.DisplayPos;
  return {pixels(ImVec2(window.Pos.x - from.x, window.Pos.y - from.y), all.FramebufferScale),
          glm::max(pixels(window.Size, all.FramebufferScale), 1)};
}

/// Draws only these lists, and clears them.
void draw_lists(const ImDrawData& all, std::vector<ImDrawList*>& lists) {
  if (lists.empty()) return;
  ImDrawData part = all;
  part.CmdLists = lists.data();
  part.CmdListsCount = static_cast<int>(lists.size());
  part.TotalVtxCount = part.TotalIdxCount = 0;
  for (const ImDrawList* list : lists) {
    part.TotalVtxCount += list->VtxBuffer.Size;
    part.TotalIdxCount += list->IdxBuffer.Size;
  }
  ImGui_ImplOpenGL3_RenderDrawData(&part);
  lists.clear();
}

GLFWcursor* create_transparent_cursor() {
  std::array<unsigned char, 4> pixel{};
  const GLFWimage image{1, 1, pixel.data()};
  return glfwCreateCursor(&image, 0, 0);
}

}  // namespace

Gui::Gui(GLFWwindow* window, float scale)
    : window_(window),
      arrow_(glfwCreateStandardCursor(GLFW_ARROW_CURSOR)),
      no_cursor_(create_transparent_cursor()),
      scale_(scale) {
  glfwSetCursor(window, arrow_);
  IMGUI_CHECKVERSION();
  ImGui::CreateContext();
  ImGuiIO& io = ImGui::GetIO();
  io.IniFilename = nullptr;  // the settings file keeps everything
  io.LogFilename = nullptr;
  io.ConfigWindowsMoveFromTitleBarOnly = true;
  io.ConfigFlags |= ImGuiConfigFlags_NoMouseCursorChange;  // show_cursor does that
  io.Fonts->Flags |= ImFontAtlasFlags_NoBakedLines;
  add_font(scale);
  set_style(scale);
  ImGui_ImplGlfw_InitForOpenGL(window, true);
  ImGui_ImplOpenGL3_Init();
  ImGui_ImplOpenGL3_CreateDeviceObjects();
  sample_nearest();
}

void Gui::set_scale(float scale) {
  if (std::exchange(scale_, scale) == scale) return;
  ImGui::GetIO().Fonts->Clear();
  add_font(scale);
  set_style(scale);
  ImGui_ImplOpenGL3_DestroyFontsTexture();
  ImGui_ImplOpenGL3_CreateFontsTexture();
  sample_nearest();
}

Gui::~Gui() {
  ImGui_ImplOpenGL3_Shutdown();
  ImGui_ImplGlfw_Shutdown();
  ImGui::DestroyContext();
  for (GLFWcursor* cursor : {arrow_, no_cursor_})
    if (cursor != nullptr) glfwDestroyCursor(cursor);
}

bool Gui::covers(glm::dvec2 cursor, std::string_view but) const {
  // ImGui's own answer, WantCaptureMouse, is for the last position of the cursor.
  const ImVec2 at(static_cast<float>(cursor.x), static_cast<float>(cursor.y));
  for (const ImGuiWindow* window : GImGui->Windows) {
    if (window->Active && !window->Hidden && !(window->Flags & ImGuiWindowFlags_NoMouseInputs) &&
        !window->IsFallbackWindow && window->Name != but && window->Rect().Contains(at))
      return true;
  }
  return false;
}

void Gui::begin(const std::optional<Held>& held) {
  ImGui_ImplOpenGL3_NewFrame();
  ImGui_ImplGlfw_NewFrame();
  ImGuiIO& io = ImGui::GetIO();
  if (held && held->button >= 0 && held->button < static_cast<int>(std::size(io.MouseDown))) {
    io.MousePos = ImVec2(static_cast<float>(held->cursor.x), static_cast<float>(held->cursor.y));
    io.MouseDown[held->button] = held->down;
  }
  ImGui::NewFrame();
}

void Gui::end() {
  ImGui::Render();
  const ImDrawData& all = *ImGui::GetDrawData();
  built_.clear();
  for (int i = 0; i < all.CmdListsCount; ++i) built_.push_back(checksum(*all.CmdLists[i]));
}

bool Gui::settling() const {
  const ImVector<ImGuiWindow*>& windows = GImGui->Windows;
  return std::any_of(windows.begin(), windows.end(), [](const ImGuiWindow* window) {
    return window->Active && window->HiddenFramesCannotSkipItems > 0;
  });
}

void Gui::show_cursor(bool shown) const {
  // Not with GLFW_CURSOR_HIDDEN: when that changes, GLFW asks for the position of the cursor and
  // swallows the event of a move to it that is still on its way. A short drag would be lost.
  glfwSetCursor(window_, shown ? arrow_ : no_cursor_);
}

void Gui::draw() {
  const ImDrawData* all = ImGui::GetDrawData();
  if (!all) return;
  drawn_ = built_;
  glBindFramebuffer(GL_FRAMEBUFFER, 0);
  glDisable(GL_FRAMEBUFFER_SRGB);  // ImGui's colours are sRGB already
  if (epoxy_gl_version() >= 45) glClipControl(GL_LOWER_LEFT, GL_NEGATIVE_ONE_TO_ONE);
  const int height = static_cast<int>(all->DisplaySize.y * all->FramebufferScale.y);
  std::vector<ImDrawList*> others;  // lists of no panel, in their order
  for (int i = 0; i < all->CmdListsCount; ++i) {
    ImDrawList* list = all->CmdLists[i];
    const ImGuiWindow* window = ImGui::FindWindowByName(list->_OwnerName);
    if (!window || (window->Flags & kOnOpaqueGround) == 0) {
      others.push_back(list);
      continue;
    }
    draw_lists(*all, others);
    if (!panels_.draw(window->Name, *list, built_[static_cast<std::size_t>(i)], *all,
                      place_of(*window, *all), height))
      others.push_back(list);
  }
  draw_lists(*all, others);
  panels_.forget_unused();
}

}  // namespace pointreel
