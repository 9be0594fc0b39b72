#include <memory>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include "server/serve/asio_types.h"
// After the header that configures Asio.
#include <boost/asio/buffer.hpp>

#include "server/serve/transport.h"
#include "server/serve/transport_stream.h"

namespace pointreel::transport_stream_test {
namespace {

using namespace std::chrono_literals;

/// A connection whose other end reads nothing.
class TransportStreamTest : public testing::Test {
 protected:
  TransportStreamTest() {
    Acceptor acceptor(asio::make_strand(context_), {asio::ip::address_v4::loopback(), 0});
    peer_.connect(acceptor.local_endpoint());
    transport_ = std::make_shared<Transport>(acceptor.accept(asio::make_strand(context_)), nullptr,
                                             10s, 10s);
  }

  asio::io_context context_;
  Socket peer_{asio::make_strand(context_)};
  std::shared_ptr<Transport> transport_;
};

// As Beast's own pings do, for which nobody waits.
TEST_F(TransportStreamTest, a_write_under_way_outlives_all_other_users_of_the_transport) {
  const std::weak_ptr<Transport> alive = transport_;
  std::optional<TransportStream> stream(std::in_place, transport_);
  // Written as often as it takes until the peer's end is full.
  transport_->socket().non_blocking(true);
  const std::vector<char> much(1 << 20);
  error_code error;
  while (!error) transport_->socket().write_some(asio::buffer(much), error);
  ASSERT_EQ(error, asio::error::would_block);
  std::optional<error_code> result;
  stream->async_write_some(asio::buffer(much),
                           [&](error_code ended, std::size_t) { result = ended; });
  context_.poll();
  ASSERT_FALSE(result);

  transport_->close();
  stream.reset();
  transport_.reset();
  EXPECT_FALSE(alive.expired());
  context_.restart();
  context_.run();
  EXPECT_EQ(result, asio::error::operation_aborted);
  EXPECT_TRUE(alive.expired());
}

}  // namespace
}  // namespace pointreel::transport_stream_test
