#pragma once

#include <string>
#include <string_view>

namespace pointreel {

/// An error's words for a server whose certificate is not trusted.
struct Untrusted {
  std::string what;
  std::string advice;  ///< what to do
};

/// `said`: why, in the words of OpenSSL or libcurl. `ca_option`: which names certificates to trust.
Untrusted untrusted(std::string_view said, std::string_view ca_option = "--ca-file");

/// What is wrong with a file of certificates from which none could be taken.
std::string fault_of_certificates(const std::string& file);

}  // namespace pointreel
