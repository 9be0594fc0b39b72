#include "codec/core/json_fields.h"

#include <cstddef>
#include <string>

#include <gtest/gtest.h>

#include "codec/package/manifest.h"
#include "common/base/json_value.h"
#include "pointreel/package.h"

namespace pointreel::json_fields_test {
namespace {

constexpr std::size_t kLong = std::size_t{4} << 20;

/// As many copies of `unit` between `head` and `tail` as kLong bytes have room for. '#' in `unit`
/// becomes a number.
std::string filled(const std::string& head, const std::string& unit, const std::string& tail) {
  std::string text = head;
  const std::size_t hash = unit.find('#');
  for (int i = 0; text.size() + unit.size() + tail.size() + 20 < kLong; ++i) {
    if (i > 0) text += ',';
    if (hash == std::string::npos) {
      text += unit;
    } else {
      text.append(unit, 0, hash).append(std::to_string(i)).append(unit, hash + 1);
    }
  }
  return text + tail;
}

// A parser whose time grew with the square of any of these lengths would take hours.
TEST(JsonFields, unknown_members_of_any_length_and_form_do_no_harm) {
  Manifest manifest;
  manifest.codec = "draco";
  manifest.layer_names = {"full"};
  std::string head = write_manifest(manifest);
  head = head.substr(0, head.rfind('}')) + ",\"unknown\":";
  for (const std::string& text :
       {filled(head + "[", "{}", "]}"), filled(head + "[", "[]", "]}"),
        filled(head + "[", "0", "]}"), filled(head + "[", "\"\"", "]}"),
        filled(head + "[", "[[[[[[[[[[[[[[]]]]]]]]]]]]]]", "]}"),
        filled(head + "[", "{\"\":{\"\":{}}}", "]}"), filled(head + "{", "\"#\":0", "}}"),
        filled(head + "[", R"({"a":[],"b":{"c":0}})", "]}"),
        head + "\"" + std::string(kLong - head.size() - 3, 'a') + "\"}"}) {
    const auto parsed = parse_manifest(text);
    EXPECT_TRUE(parsed) << text.substr(head.size(), 20) << ": " << parsed.error().message;
  }
}

TEST(JsonFields, refuse_an_object_of_more_members_than_any_of_ours_has) {
  const auto check = [](std::size_t members) {
    std::string text = "{\"known\":1";
    for (std::size_t i = 1; i < members; ++i) text += ",\"" + std::to_string(i) + "\":0";
    text += '}';
    Fields fields(parse_json(text).value());
    return fields.integer("known", 1) == 1;
  };
  EXPECT_TRUE(check(kMaxMembers));
  EXPECT_FALSE(check(kMaxMembers + 1));
}

}  // namespace
}  // namespace pointreel::json_fields_test
