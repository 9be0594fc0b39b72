#include "common/net/client_transport.h"

#include <boost/beast/ssl/ssl_stream.hpp>
#include <boost/beast/websocket/ssl.hpp>
#include <boost/beast/websocket/teardown.hpp>
#include <openssl/x509v3.h>

namespace pointreel {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;

using Socket = ClientTransport::Socket;
using SecureSocket = beast::ssl_stream<Socket>;

template <class Stream>
class TransportOn : public ClientTransport {
 public:
  template <class... From>
  explicit TransportOn(From&&... from) : stream_(std::forward<From>(from)...) {}

  Socket& socket() override { return beast::get_lowest_layer(stream_); }

  void handshake([[maybe_unused]] const std::string& host,
                 [[maybe_unused]] Completion done) override {
    if constexpr (std::same_as<Stream, SecureSocket>) {
      ::SSL_set_tlsext_host_name(stream_.native_handle(), host.c_str());
      stream_.set_verify_mode(asio::ssl::verify_peer);
      if (::X509_VERIFY_PARAM_set1_ip_asc(::SSL_get0_param(stream_.native_handle()),
                                          host.c_str()) != 1) {
        ::SSL_set_hostflags(stream_.native_handle(), X509_CHECK_FLAG_NO_PARTIAL_WILDCARDS);
        ::SSL_set1_host(stream_.native_handle(), host.c_str());
      }
      stream_.async_handshake(asio::ssl::stream_base::client, std::move(done));
    }
  }

  std::string distrust() override {
    if constexpr (std::same_as<Stream, SecureSocket>) {
      const long result = ::SSL_get_verify_result(stream_.native_handle());
      if (result != X509_V_OK) return ::X509_verify_cert_error_string(result);
    }
    return {};
  }

  void read_some(const Pieces<asio::mutable_buffer>& into, Completion done) override {
    stream_.async_read_some(into, std::move(done));
  }

  void write_some(const Pieces<asio::const_buffer>& from, Completion done) override {
    stream_.async_write_some(from, std::move(done));
  }

  void tear_down(beast::role_type role, Completion done) override {
    using beast::websocket::async_teardown;
    async_teardown(role, stream_, std::move(done));
  }

 private:
  Stream stream_;
};

}  // namespace

std::unique_ptr<ClientTransport> ClientTransport::make(asio::io_context& context,
                                                       asio::ssl::context* tls) {
  if (tls == nullptr) return std::make_unique<TransportOn<Socket>>(context);
  return std::make_unique<TransportOn<SecureSocket>>(context, *tls);
}

void ClientTransport::close() {
  boost::system::error_code ignored;
  socket().close(ignored);
}

}  // namespace pointreel
