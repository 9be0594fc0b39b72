#include "server/service/entity_tag.h"

#include <fmt/format.h>

namespace pointreel {
namespace {

bool any_tag_matches(std::string_view list, std::string_view etag, bool weak_counts) {
  const auto skip = [&list](std::string_view what) {
    const auto at = list.find_first_not_of(what);
    list.remove_prefix(at == std::string_view::npos ? list.size() : at);
  };
  skip(" \t");
  if (list.starts_with('*')) {
    list.remove_prefix(1);
    skip(" \t");
    return list.empty();
  }
  // A tag may hold commas, so the list cannot simply be split at them.
  while (true) {
    skip(" \t,");
    const bool weak = list.starts_with("W/");
    if (weak) list.remove_prefix(2);
    if (!list.starts_with('"')) return false;
    const auto end = list.find('"', 1);
    if (end == std::string_view::npos) return false;
    if ((weak_counts || !weak) && list.substr(0, end + 1) == etag) return true;
    list.remove_prefix(end + 1);
    skip(" \t");
    if (!list.starts_with(',')) return false;
  }
}

}  // namespace

std::string make_etag(std::uint64_t checksum) { return fmt::format("\"{:016x}\"", checksum); }

bool matches_weakly(std::string_view list, std::string_view etag) {
  return any_tag_matches(list, etag, true);
}

bool matches_strongly(std::string_view list, std::string_view etag) {
  return any_tag_matches(list, etag, false);
}

}  // namespace pointreel
