#include "server/serve/tls.h"

#include <algorithm>
#include <climits>
#include <string>
#include <system_error>
#include <utility>

#include <fmt/format.h>
#include <openssl/err.h>
#include <openssl/ssl.h>

namespace pointreel {
namespace {

/// Chooses HTTP/1.1, whatever else a client offers. A client that offers only other protocols is
/// not refused, but it still gets HTTP/1.1.
int choose_protocol(SSL*, const unsigned char** chosen, unsigned char* chosen_size,
                    const unsigned char* offered, unsigned offered_size, void*) {
  static constexpr unsigned char kOurs[] = "\x08http/1.1";
  const int found = SSL_select_next_proto(const_cast<unsigned char**>(chosen), chosen_size, kOurs,
                                          sizeof(kOurs) - 1, offered, offered_size);
  return found == OPENSSL_NPN_NEGOTIATED ? SSL_TLSEXT_ERR_OK : SSL_TLSEXT_ERR_NOACK;
}

/// Keeps OpenSSL from asking for a password on the terminal.
int no_password(char*, int, int, void*) { return 0; }

/// OpenSSL's description of the last error, in a few words. Empties its queue of errors.
std::string reason() {
  const unsigned long code = ERR_peek_error();  // the first is the cause
  const char* text = ERR_SYSTEM_ERROR(code) ? nullptr : ERR_reason_error_string(code);
  const std::string words = text != nullptr ? text
                            : ERR_SYSTEM_ERROR(code)
                                ? std::generic_category().message(ERR_GET_REASON(code))
                                : "cannot be read";
  ERR_clear_error();
  return words;
}

}  // namespace

void TlsSession::Free::operator()(ssl_st* ssl) const { SSL_free(ssl); }
void TlsContext::Free::operator()(ssl_ctx_st* context) const { SSL_CTX_free(context); }

TlsSession::Step TlsSession::step(int result) {
  if (result > 0) return {Step::Want::kNothing, static_cast<std::size_t>(result)};
  const int error = SSL_get_error(ssl_.get(), result);
  if (error == SSL_ERROR_WANT_READ) return {Step::Want::kRead};
  if (error == SSL_ERROR_WANT_WRITE) return {Step::Want::kWrite};
  return {Step::Want::kEnd};
}

// SSL_get_error examines the thread's queue of errors, which must therefore be empty before each
// step.
TlsSession::Step TlsSession::handshake() {
  ERR_clear_error();
  return step(SSL_do_handshake(ssl_.get()));
}

TlsSession::Step TlsSession::read(std::span<char> into) {
  ERR_clear_error();
  return step(SSL_read(ssl_.get(), into.data(),
                       static_cast<int>(std::min<std::size_t>(into.size(), INT_MAX))));
}

TlsSession::Step TlsSession::write(std::string_view text) {
  ERR_clear_error();
  return step(SSL_write(ssl_.get(), text.data(),
                        static_cast<int>(std::min<std::size_t>(text.size(), INT_MAX))));
}

void TlsSession::end_writing() {
  ERR_clear_error();
  SSL_shutdown(ssl_.get());
  ERR_clear_error();
}

Result<TlsContext> TlsContext::load(const std::filesystem::path& certificate,
                                    const std::filesystem::path& key) {
  ERR_clear_error();
  TlsContext tls;
  tls.context_.reset(SSL_CTX_new(TLS_server_method()));
  SSL_CTX* context = tls.context_.get();
  if (context == nullptr) return fail(fmt::format("TLS: {}", reason()));
  SSL_CTX_set_min_proto_version(context, TLS1_2_VERSION);
  SSL_CTX_set_options(context, SSL_OP_NO_RENEGOTIATION | SSL_OP_NO_COMPRESSION |
                                   SSL_OP_CIPHER_SERVER_PREFERENCE | SSL_OP_PRIORITIZE_CHACHA);
  // Idle connections hold no buffers, and partial writes are continued.
  SSL_CTX_set_mode(context, SSL_MODE_RELEASE_BUFFERS | SSL_MODE_ENABLE_PARTIAL_WRITE |
                                SSL_MODE_ACCEPT_MOVING_WRITE_BUFFER);
  SSL_CTX_set_alpn_select_cb(context, choose_protocol, nullptr);
  SSL_CTX_set_default_passwd_cb(context, no_password);
  if (SSL_CTX_use_certificate_chain_file(context, certificate.c_str()) != 1) {
    return fail(
        fmt::format("{}: {}; give a certificate in PEM form", certificate.string(), reason()));
  }
  if (SSL_CTX_use_PrivateKey_file(context, key.c_str(), SSL_FILETYPE_PEM) != 1) {
    return fail(fmt::format("{}: {}; give the certificate's key in PEM form, without a password",
                            key.string(), reason()));
  }
  // Keys of another type than the certificate's are only found here.
  if (SSL_CTX_check_private_key(context) != 1) {
    return fail(
        fmt::format("{}: is not the key of {} ({})", key.string(), certificate.string(), reason()));
  }
  return tls;
}

std::unique_ptr<TlsSession> TlsContext::session(int socket) const {
  std::unique_ptr<TlsSession> session(new TlsSession(SSL_new(context_.get())));
  SSL* ssl = session->ssl_.get();
  if (ssl == nullptr || SSL_set_fd(ssl, socket) != 1) return nullptr;
  SSL_set_accept_state(ssl);
  return session;
}

}  // namespace pointreel
