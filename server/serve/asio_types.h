#pragma once

#include <chrono>
#include <utility>  // Before Asio: the awaitable.hpp of Boost 1.74 uses std::exchange without it.

// Boost 1.74 knows only the coroutines that clang had before C++20. These macros make it use those
// of the standard, so every source takes awaitable, co_spawn and use_awaitable from here.
#define BOOST_ASIO_HAS_CO_AWAIT 1
#define BOOST_ASIO_HAS_STD_COROUTINE 1
#include <boost/asio/awaitable.hpp>
#include <boost/asio/basic_socket_acceptor.hpp>
#include <boost/asio/basic_stream_socket.hpp>
#include <boost/asio/basic_waitable_timer.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/strand.hpp>
#include <boost/asio/use_awaitable.hpp>

/// Types that the sources which work with sockets share. Asio takes long to compile, so only the
/// headers that these sources need include it.
namespace pointreel {

namespace asio = boost::asio;
using boost::system::error_code;
using Clock = std::chrono::steady_clock;

// Each connection has one strand. The types of the executors are spelt out, because Asio's defaults
// erase them, which costs time on every operation.
using Strand = asio::strand<asio::io_context::executor_type>;
using Socket = asio::basic_stream_socket<asio::ip::tcp, Strand>;
using Acceptor = asio::basic_socket_acceptor<asio::ip::tcp, Strand>;
using Timer = asio::basic_waitable_timer<Clock, asio::wait_traits<Clock>, Strand>;
template <class T>
using Task = asio::awaitable<T, Strand>;
constexpr asio::use_awaitable_t<Strand> kUseAwaitable{};

}  // namespace pointreel
