#include "client/ui/drawing_panel.h"

#include <functional>
#include <set>
#include <utility>

#include <gtest/gtest.h>
#include <imgui.h>
#include <imgui_internal.h>

namespace pointreel::drawing_panel_test {
namespace {

constexpr glm::vec2 kSize(900.0f, 700.0f);

/// The panel without a window: the draw commands are discarded.
class DrawingPanelTest : public testing::Test {
 protected:
  DrawingPanelTest() {
    ImGui::CreateContext();
    ImGuiIO& io = ImGui::GetIO();
    io.IniFilename = nullptr;
    io.ConfigWindowsMoveFromTitleBarOnly = true;  // as Gui sets it
    io.DisplaySize = {kSize.x, kSize.y};
    io.DeltaTime = 0.02f;
    unsigned char* pixels = nullptr;
    int width = 0, height = 0;
    io.Fonts->GetTexDataAsRGBA32(&pixels, &width, &height);
    for (int i = 0; i < 3; ++i) build();  // until the panel has its size
  }
  ~DrawingPanelTest() override { ImGui::DestroyContext(); }

  bool build() {
    ImGui::NewFrame();
    settings_.drawing_panel = open_;
    const Settings before = settings_;
    const bool changed =
        drawing_panel(settings_, fields_, {{12.0f, 48.0f}, kSize - glm::vec2(20.0f, 56.0f)},
                      std::exchange(place_, false), 1.0f);
    EXPECT_EQ(changed, before != settings_);
    open_ = std::exchange(settings_.drawing_panel, false);
    ImGui::Render();
    return changed;
  }

  void at(float x, float y, bool down) {
    ImGui::GetIO().MousePos = {x, y};
    ImGui::GetIO().MouseDown[0] = down;
    build();
  }
  void press(float x, float y) {
    at(x, y, false);
    at(x, y, true);
    at(x, y, false);
  }
  void drag(float x, float y, float by) {
    at(x, y, false);
    at(x, y, true);
    at(x + by, y, true);
    at(x + by, y, false);
  }
  /// Closes any popup.
  void leave() {
    press(3.0f, kSize.y - 3.0f);
    press(3.0f, kSize.y - 3.0f);
  }

  static ImRect panel() { return ImGui::FindWindowByName("Drawing")->Rect(); }

  /// Calls `act` at places all over `part`, except for the title bar and its close button.
  void all_over(const ImRect& part, float step, const std::function<void(float, float)>& act) {
    for (float y = part.Min.y + 24.0f; y < part.Max.y; y += step)
      for (float x = part.Min.x + 4.0f; x < part.Max.x; x += step) act(x, y);
  }

  void expect_in_range() const {
    const DrawOptions& draw = settings_.draw;
    const auto within = [](double value, double least, double most) {
      return value >= least && value <= most;
    };
    EXPECT_TRUE(within(settings_.delta, 0.0, 1.0)) << settings_.delta;
    EXPECT_TRUE(within(draw.scales.visibility, 0.01, 100.0));
    EXPECT_TRUE(within(draw.scales.shading, 0.01, 100.0));
    EXPECT_TRUE(within(draw.edl, 0.0, 100.0));
    EXPECT_TRUE(within(draw.pixel_size, 0.0, 1000.0));
    EXPECT_TRUE(within(draw.point_size, 0.5, 100.0));
    for (int i = 0; i < 3; ++i) EXPECT_TRUE(within(draw.background[i], 0.0, 1.0));
    EXPECT_LT(static_cast<int>(draw.splatting), static_cast<int>(kEnumNames<Splatting>.size()));
    EXPECT_LT(static_cast<int>(draw.instancing), static_cast<int>(kEnumNames<Instancing>.size()));
  }

  Settings settings_;
  const std::vector<std::string> fields_ = {"intensity", "class"};
  bool open_ = true;
  bool place_ = true;
};

TEST_F(DrawingPanelTest, changes_nothing_until_it_is_used) {
  Settings odd;
  odd.delta = 0.123456789012;
  odd.draw.scales = {0.01f, 100.0f};  // outside the range of the sliders
  odd.draw.edl = 50.0f;
  odd.draw.pixel_size = 900.0f;
  odd.draw.background = {0.123f, 0.456f, 0.789f};
  for (const auto& known : kEnumNames<DrawMode>) {
    const DrawMode mode = known.value;
    settings_ = odd;
    settings_.draw.mode = mode;
    const Settings before = settings_;
    for (int i = 0; i < 5; ++i) EXPECT_FALSE(build());
    // Moving the mouse over it changes nothing either.
    all_over(panel(), 16.0f, [this](float x, float y) { at(x, y, false); });
    EXPECT_EQ(settings_, before);
  }
  EXPECT_TRUE(open_);
}

TEST_F(DrawingPanelTest, the_mouse_reaches_every_control_and_values_stay_in_range) {
  std::set<DrawMode> modes;
  std::set<bool> holes, lights, floors;
  std::set<float> visibility, shading, edl, detail, point_size, gray;
  std::set<double> delta;
  for (const auto& known : kEnumNames<DrawMode>) {
    const DrawMode mode = known.value;
    settings_ = {};
    settings_.draw.mode = mode;
    for (int i = 0; i < 3; ++i) build();
    const ImRect place = panel();
    all_over(place, 9.0f, [&](float x, float y) {
      settings_ = {};
      settings_.draw.mode = mode;
      drag(x, y, 4.0f);
      expect_in_range();
      const DrawOptions& draw = settings_.draw;
      modes.insert(draw.mode);
      holes.insert(draw.fill_holes);
      lights.insert(draw.lighting);
      floors.insert(settings_.floor);
      visibility.insert(draw.scales.visibility);
      shading.insert(draw.scales.shading);
      edl.insert(draw.edl);
      detail.insert(draw.pixel_size);
      point_size.insert(draw.point_size);
      gray.insert(draw.background.x);
      delta.insert(settings_.delta);
      if (!GImGui->OpenPopupStack.empty()) leave();
    });
  }
  EXPECT_TRUE(open_);
  EXPECT_EQ(modes.size(), kEnumNames<DrawMode>.size());
  for (const auto& flag : {holes, lights, floors}) EXPECT_EQ(flag.size(), 2u);
  for (const auto& slider : {visibility, shading, edl, detail, point_size})
    EXPECT_GT(slider.size(), 5u);
  EXPECT_GT(delta.size(), 5u);
  EXPECT_GE(gray.size(), 4u);
}

TEST_F(DrawingPanelTest, every_item_of_a_list_can_be_chosen) {
  std::set<Drafts> drafts;
  std::set<ColorSource> colors;
  std::set<std::string> fields;
  std::set<Light> lights;
  std::set<Splatting> splattings;
  std::set<Instancing> instancings;
  const ImRect place = panel();
  const float x = place.Min.x + 60.0f;
  for (float y = place.Min.y + 24.0f; y < place.Max.y; y += 9.0f) {
    settings_ = {};
    press(x, y);
    if (GImGui->OpenPopupStack.empty()) continue;
    leave();
    // Press each item of the popup.
    for (float down = -10.0f; down < 190.0f; down += 8.0f) {
      settings_ = {};
      press(x, y);
      press(x + 8.0f, y + down);
      expect_in_range();
      splattings.insert(settings_.draw.splatting);
      instancings.insert(settings_.draw.instancing);
      colors.insert(settings_.draw.color);
      fields.insert(settings_.scalar.field);
      lights.insert(settings_.draw.light);
      drafts.insert(settings_.drafts);
      if (!GImGui->OpenPopupStack.empty()) leave();
    }
  }
  EXPECT_EQ(splattings.size(), kEnumNames<Splatting>.size());
  EXPECT_EQ(instancings.size(), kEnumNames<Instancing>.size());
  EXPECT_EQ(drafts.size(), kEnumNames<Drafts>.size());
  EXPECT_EQ(colors.size(), kEnumNames<ColorSource>.size());
  EXPECT_EQ(fields, (std::set<std::string>{"", "intensity", "class"}));
  EXPECT_EQ(lights.size(), kEnumNames<Light>.size());
}

TEST_F(DrawingPanelTest, defaults_restore_everything_but_the_mode) {
  Settings odd;
  odd.draw.mode = DrawMode::voxel;
  odd.delta = 0.2;
  odd.draw.edl = 2.0f;
  odd.draw.color = ColorSource::plain;
  odd.floor = true;
  odd.drafts = Drafts::never;
  odd.size = {800, 600};  // what is not in the panel stays
  odd.loop = false;
  settings_ = odd;
  for (int i = 0; i < 3; ++i) build();
  bool restored = false;
  all_over(panel(), 9.0f, [&](float x, float y) {
    settings_ = odd;
    press(x, y);
    Settings fresh;
    fresh.draw.mode = DrawMode::voxel;
    fresh.size = odd.size;
    fresh.loop = odd.loop;
    restored = restored || settings_ == fresh;
    if (!GImGui->OpenPopupStack.empty()) leave();
  });
  EXPECT_TRUE(restored);
}

TEST_F(DrawingPanelTest, closes_by_its_button_and_takes_no_keys) {
  EXPECT_FALSE(ImGui::GetIO().WantCaptureKeyboard && ImGui::GetIO().WantTextInput);
  const ImRect place = panel();
  press(place.Max.x - 12.0f, place.Min.y + 10.0f);
  EXPECT_FALSE(open_);
}

}  // namespace
}  // namespace pointreel::drawing_panel_test
