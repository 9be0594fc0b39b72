#include "client/ui/gui.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>

#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <epoxy/gl.h>
#include <imgui.h>
#include <imgui_internal.h>

namespace pointreel {
namespace {

constexpr const char* kFont = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf";
constexpr float kFontSize = 14.0f;

/// Latin, Greek and Cyrillic: names of files are shown.
constexpr std::array<ImWchar, 7> kGlyphs = {0x0020, 0x024f, 0x0370, 0x052f, 0x2010, 0x2044, 0};

void add_font(float scale) {
  ImFontAtlas& fonts = *ImGui::GetIO().Fonts;
  if (std::filesystem::exists(kFont)) {
    // On whole pixels, as sample_nearest needs.
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

/// The texture that all but pictures is drawn with has nothing between its pixels that is to be
/// seen. On software OpenGL the interface is drawn in half the time so.
void sample_nearest() {
  const auto font =
      static_cast<GLuint>(reinterpret_cast<std::uintptr_t>(ImGui::GetIO().Fonts->TexID));
  glBindTexture(GL_TEXTURE_2D, font);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
}

void set_style(float scale) {
  ImGuiStyle& style = ImGui::GetStyle();
  ImGui::StyleColorsDark();
  style.WindowRounding = style.FrameRounding = style.GrabRounding = 4.0f;
  style.WindowBorderSize = 0.0f;
  style.Colors[ImGuiCol_WindowBg] = {0.07f, 0.075f, 0.085f, 0.88f};
  style.Colors[ImGuiCol_TitleBg] =
      style.Colors[ImGuiCol_TitleBgActive] = {0.12f, 0.13f, 0.15f, 0.95f};
  style.ScaleAllSizes(scale);
}

}  // namespace

Gui::Gui(GLFWwindow* window, float scale) : scale_(scale) {
  IMGUI_CHECKVERSION();
  ImGui::CreateContext();
  ImGuiIO& io = ImGui::GetIO();
  io.IniFilename = nullptr;  // what is remembered is in the settings file
  io.LogFilename = nullptr;
  io.ConfigWindowsMoveFromTitleBarOnly = true;
  io.Fonts->Flags |= ImFontAtlasFlags_NoBakedLines;
  add_font(scale);
  set_style(scale);
  ImGui_ImplGlfw_InitForOpenGL(window, true);
  ImGui_ImplOpenGL3_Init();
  ImGui_ImplOpenGL3_CreateDeviceObjects();
  sample_nearest();
}

Gui::~Gui() {
  ImGui_ImplOpenGL3_Shutdown();
  ImGui_ImplGlfw_Shutdown();
  ImGui::DestroyContext();
}

bool Gui::covers(glm::dvec2 cursor, std::string_view but) const {
  // ImGui's own answer, WantCaptureMouse, is that of the cursor's last place.
  const ImVec2 at(static_cast<float>(cursor.x), static_cast<float>(cursor.y));
  for (const ImGuiWindow* window : GImGui->Windows) {
    if (window->Active && !window->Hidden && !(window->Flags & ImGuiWindowFlags_NoMouseInputs) &&
        !window->IsFallbackWindow && window->Name != but && window->Rect().Contains(at))
      return true;
  }
  return false;
}

void Gui::begin() {
  ImGui_ImplOpenGL3_NewFrame();
  ImGui_ImplGlfw_NewFrame();
  ImGui::NewFrame();
}

void Gui::end() { ImGui::Render(); }

void Gui::draw() {
  ImDrawData* drawn = ImGui::GetDrawData();
  if (!drawn || drawn->CmdListsCount == 0) return;
  glBindFramebuffer(GL_FRAMEBUFFER, 0);
  glDisable(GL_FRAMEBUFFER_SRGB);  // its colours are sRGB already
  if (epoxy_gl_version() >= 45) glClipControl(GL_LOWER_LEFT, GL_NEGATIVE_ONE_TO_ONE);
  ImGui_ImplOpenGL3_RenderDrawData(drawn);
}

}  // namespace pointreel
