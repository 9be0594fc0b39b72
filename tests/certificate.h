#pragma once

#include <cstdio>
#include <filesystem>
#include <memory>

#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/x509v3.h>

namespace pointreel {

/// A self-signed certificate for localhost and 127.0.0.1, made for one test: the server uses it,
/// and the client trusts it.
struct TestCertificate {
  std::filesystem::path certificate, key;

  explicit TestCertificate(const std::filesystem::path& folder)
      : certificate(folder / "certificate.pem"), key(folder / "key.pem") {
    const std::unique_ptr<EVP_PKEY, decltype(&EVP_PKEY_free)> pair(EVP_EC_gen("P-256"),
                                                                   EVP_PKEY_free);
    const std::unique_ptr<X509, decltype(&X509_free)> x509(X509_new(), X509_free);
    X509_set_version(x509.get(), 2);
    ASN1_INTEGER_set(X509_get_serialNumber(x509.get()), 1);
    X509_gmtime_adj(X509_getm_notBefore(x509.get()), -86400);
    X509_gmtime_adj(X509_getm_notAfter(x509.get()), 86400);
    X509_set_pubkey(x509.get(), pair.get());
    X509_NAME* name = X509_get_subject_name(x509.get());
    X509_NAME_add_entry_by_txt(name, "CN", MBSTRING_ASC,
                               reinterpret_cast<const unsigned char*>("localhost"), -1, -1, 0);
    X509_set_issuer_name(x509.get(), name);
    add(x509.get(), NID_basic_constraints, "critical,CA:TRUE");
    add(x509.get(), NID_subject_alt_name, "DNS:localhost,IP:127.0.0.1");
    X509_sign(x509.get(), pair.get(), EVP_sha256());
    write(certificate, [&](std::FILE* file) { PEM_write_X509(file, x509.get()); });
    write(key, [&](std::FILE* file) {
      PEM_write_PrivateKey(file, pair.get(), nullptr, nullptr, 0, nullptr, nullptr);
    });
  }

 private:
  static void add(X509* x509, int kind, const char* value) {
    X509V3_CTX context;
    X509V3_set_ctx_nodb(&context);
    X509V3_set_ctx(&context, x509, x509, nullptr, nullptr, 0);
    X509_EXTENSION* extension = X509V3_EXT_conf_nid(nullptr, &context, kind, value);
    X509_add_ext(x509, extension, -1);
    X509_EXTENSION_free(extension);
  }
  template <class Writer>
  static void write(const std::filesystem::path& path, const Writer& writer) {
    if (std::FILE* file = std::fopen(path.c_str(), "w")) {
      writer(file);
      std::fclose(file);
    }
  }
};

}  // namespace pointreel
