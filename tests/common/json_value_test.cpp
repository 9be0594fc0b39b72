#include "common/base/json_value.h"

#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace pointreel::json_value_test {
namespace {

using nlohmann::json;
using testing::HasSubstr;

std::string error_of(const std::string& text) {
  const auto value = parse_json(text);
  return value ? "accepted" : value.error().message;
}

/// The same value as a tree, made with the functions of JsonValue alone.
json tree_of(const JsonValue& value) {
  if (value.is_null()) return nullptr;
  if (const auto boolean = value.boolean()) return *boolean;
  if (const auto integer = value.integer()) return *integer;
  if (const auto number = value.number()) return *number;
  if (const auto string = value.string()) return *string;
  json tree = value.is_object() ? json::object() : json::array();
  for (JsonItems item(value); item.next();) {
    if (value.is_object()) {
      tree[item.key().string().value()] = tree_of(item.value());
    } else {
      tree.push_back(tree_of(item.value()));
    }
  }
  EXPECT_EQ(value.size(), tree.size());
  return tree;
}

json random_tree(std::mt19937& random, int depth) {
  static const std::vector<json> kLeaves = {nullptr,
                                            true,
                                            false,
                                            0,
                                            7,
                                            -3,
                                            18446744073709551615u,
                                            0.1,
                                            -1e300,
                                            5e-324,
                                            "",
                                            "a",
                                            "\"\\/\b\n\t",
                                            "}],:{[",
                                            "\u00e4\U0001f600",
                                            std::string("\0x", 2)};
  const unsigned kind = random() % 4;
  if (depth == 0 || kind > 1) return kLeaves[random() % kLeaves.size()];
  json tree = kind == 0 ? json::object() : json::array();
  for (auto i = random() % 5; i > 0; --i) {
    json item = random_tree(random, depth - 1);
    if (kind == 1) {
      tree.push_back(std::move(item));
    } else {
      const json& key = kLeaves[random() % kLeaves.size()];
      tree[key.is_string() ? key.get<std::string>() : key.dump()] = std::move(item);
    }
  }
  return tree;
}

TEST(JsonValue, reads_what_another_parser_reads) {
  std::mt19937 random(1);
  for (int i = 0; i < 2000; ++i) {
    const json tree = random_tree(random, 5);
    for (const std::string& text :
         {tree.dump(), tree.dump(2), tree.dump(-1, ' ', true), " \r\n\t" + tree.dump(1, '\t') + " ",
          "\xef\xbb\xbf" + tree.dump()}) {
      const auto value = parse_json(text);
      ASSERT_TRUE(value) << text << ": " << value.error().message;
      EXPECT_EQ(tree_of(*value), tree) << text;
    }
  }
}

TEST(JsonValue, refuses_what_another_parser_refuses) {
  std::mt19937 random(2);
  int refused = 0;
  for (int i = 0; i < 5000; ++i) {
    std::string text = random_tree(random, 4).dump();
    const std::size_t at = random() % text.size();
    switch (random() % 3) {
      case 0:
        text.resize(at);
        break;
      case 1:
        text[at] = "{}[],:\"\\0e-.tn \xff"[random() % 17];
        break;
      default:
        text.insert(at, 1, "{}[],:\"\\0e-.tn \xff"[random() % 17]);
    }
    const std::string error = error_of(text);
    // The other parser takes a NUL for the end of the text.
    const bool valid = json::accept(text) && text.find('\0') == std::string::npos;
    refused += !valid;
    EXPECT_EQ(error == "is not valid JSON", !valid && error.find("twice") == std::string::npos)
        << text;
  }
  EXPECT_GT(refused, 100);
}

TEST(JsonValue, nothing_may_follow_behind_a_nul) {
  for (const std::string& text : {std::string("{}\0", 3), std::string("{}\0garbage", 10)}) {
    EXPECT_EQ(error_of(text), "is not valid JSON");
  }
}

TEST(JsonValue, whole_numbers_have_no_fraction_no_exponent_and_no_sign) {
  const auto integer = [](const char* text) { return parse_json(text).value().integer(); };
  EXPECT_EQ(integer("0"), 0u);
  EXPECT_EQ(integer("18446744073709551615"), ~std::uint64_t{0});
  for (const char* other : {"18446744073709551616", "-0", "-1", "1.0", "1e2", "\"1\"", "true"}) {
    EXPECT_EQ(integer(other), std::nullopt) << other;
  }
  EXPECT_EQ(parse_json("1e2").value().number(), 100.0);
  EXPECT_EQ(parse_json("1e-400").value().number(), 0.0);
  EXPECT_EQ(error_of("1e400"), "is not valid JSON");
}

TEST(JsonValue, a_key_is_the_same_key_however_it_is_written) {
  const std::string text = R"({"\u006eame": 1})";
  JsonItems item(parse_json(text).value());
  ASSERT_TRUE(item.next());
  EXPECT_TRUE(is_text(item.key(), "name"));
  EXPECT_FALSE(is_text(item.key(), "nam"));
  EXPECT_THAT(error_of(R"({"a": [{"\u006eame": 1, "name": 2}]})"), HasSubstr("same key twice"));
  EXPECT_EQ(error_of(R"({"a": {"b": 1}, "b": {"a": 1}})"), "accepted");
}

TEST(JsonValue, is_nested_at_most_sixteen_deep) {
  EXPECT_EQ(error_of(std::string(16, '[') + std::string(16, ']')), "accepted");
  EXPECT_EQ(error_of(std::string(17, '[') + std::string(17, ']')), "is nested too deep");
  EXPECT_EQ(error_of(std::string(std::size_t{32} << 20, '[')), "is nested too deep");
}

}  // namespace
}  // namespace pointreel::json_value_test
