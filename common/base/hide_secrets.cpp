#include "common/base/hide_secrets.h"

#include <algorithm>

namespace pointreel {

std::string hide_secrets(std::string_view text) {
  constexpr std::string_view kAuthority = "://", kEnds = " \t\r\n\"'`<>";
  std::string shown;
  for (;;) {
    const std::size_t begin = text.find(kAuthority);
    if (begin == std::string_view::npos) return shown + std::string(text);
    shown += text.substr(0, begin + kAuthority.size());
    text.remove_prefix(begin + kAuthority.size());
    std::string_view address = text.substr(0, text.find_first_of(kEnds));
    text.remove_prefix(address.size());
    // What follows an address in a sentence.
    const std::size_t last = address.find_last_not_of(":,;.)");
    std::string_view behind = address.substr(last == address.npos ? 0 : last + 1);
    address.remove_suffix(behind.size());
    // A "?" in a password looks like a query, which then hides the host, too.
    const std::size_t user = address.substr(0, address.find('/')).rfind('@');
    const std::size_t query = address.find('?');
    if (query == address.npos) {
      shown += address.substr(user == address.npos ? 0 : user + 1);
    } else {
      if (user == address.npos)
        shown += address.substr(0, query);
      else if (user < query)
        shown += address.substr(user + 1, query - user - 1);
      shown += "?...";
      if (behind.starts_with("...")) behind.remove_prefix(3);
    }
    shown += behind;
  }
}

}  // namespace pointreel
