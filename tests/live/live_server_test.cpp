#include "mimbre/live_server.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <boost/asio/connect.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <cstring>
#include <nlohmann/json.hpp>
#include <random>
#include <thread>

#include "mimbre/diagnostics.h"
#include "support/clocked.h"
#include "support/models.h"
#include "support/simulate.h"

namespace mimbre::test::live_server_test {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using tcp = asio::ip::tcp;
using Json = nlohmann::json;
using testing::HasSubstr;

/// A loop that runs and is served.
class Live {
 public:
  explicit Live(const std::string& token = "")
      : simulation_(simulation_of(controlled_four_bar(), Formulation::relative, 0.005)),
        loop_(simulation_, options()),
        server_(simulation_, loop_, {"127.0.0.1", 0, token, nullptr}),
        runs_([this] { loop_.run(); }) {}
  ~Live() {
    loop_.stop();
    runs_.join();
  }
  RealTimeLoop& loop() { return loop_; }
  int port() const { return server_.port(); }
  std::string url() const { return server_.url(); }
  const std::vector<spec::Input>& inputs() const { return simulation_.inputs(); }

 private:
  static RealTimeOptions options() {
    RealTimeOptions o;
    o.lock_memory = false;
    o.rests_at_end = true;
    return o;
  }
  Simulation simulation_;
  RealTimeLoop loop_;
  LiveServer server_;
  std::thread runs_;
};

/// Raw bytes there, and what comes back until the other side closes.
class Wire {
 public:
  explicit Wire(int port) : socket_(context_) {
    socket_.connect({asio::ip::address_v4::loopback(), static_cast<unsigned short>(port)});
  }
  tcp::socket& socket() { return socket_; }
  void send(const std::string& bytes) {
    boost::system::error_code ignored;
    asio::write(socket_, asio::buffer(bytes), ignored);
  }

 private:
  asio::io_context context_;
  tcp::socket socket_;
};

http::response<http::string_body> get(int port, const std::string& target,
                                      const std::map<std::string, std::string>& fields = {},
                                      http::verb verb = http::verb::get) {
  Wire wire(port);
  http::request<http::empty_body> request(verb, target, 11);
  request.set(http::field::host, "127.0.0.1:" + std::to_string(port));
  for (const auto& [name, value] : fields) request.set(name, value);
  http::write(wire.socket(), request);
  beast::flat_buffer buffer;
  http::response_parser<http::string_body> parser;
  parser.body_limit(64 * 1024 * 1024);
  parser.skip(verb == http::verb::head);
  http::read(wire.socket(), buffer, parser);
  return parser.release();
}

class Viewer {
 public:
  explicit Viewer(int port, const std::string& target = "/ws", const std::string& origin = "")
      : socket_(context_) {
    beast::get_lowest_layer(socket_).connect(
        {asio::ip::address_v4::loopback(), static_cast<unsigned short>(port)});
    const std::string host = "127.0.0.1:" + std::to_string(port);
    if (!origin.empty())
      socket_.set_option(websocket::stream_base::decorator(
          [origin](websocket::request_type& request) { request.set(http::field::origin, origin); }));
    socket_.handshake(host, target);
    hello = until("hello");
  }
  void say(const Json& message) {
    socket_.text(true);
    socket_.write(asio::buffer(message.dump()));
  }
  /// The next message of either kind.
  std::string next(bool& binary) {
    beast::flat_buffer buffer;
    socket_.read(buffer);
    binary = socket_.got_binary();
    return beast::buffers_to_string(buffer.data());
  }
  Json until(const std::string& what) {
    for (int k = 0; k < 10'000; ++k) {
      bool binary = false;
      const std::string text = next(binary);
      if (binary) continue;
      Json message = Json::parse(text);
      if (message["say"] == what) return message;
    }
    ADD_FAILURE() << "nothing was said of " << what;
    return {};
  }
  std::string picture() {
    for (int k = 0; k < 100; ++k) {
      bool binary = false;
      std::string bytes = next(binary);
      if (binary) return bytes;
    }
    ADD_FAILURE() << "no picture came";
    return {};
  }
  websocket::stream<tcp::socket>& socket() { return socket_; }

  Json hello;

 private:
  asio::io_context context_;
  websocket::stream<tcp::socket> socket_;
};

template <class Number>
Number number_at(const std::string& bytes, std::size_t place) {
  Number number{};
  EXPECT_LE(place + sizeof number, bytes.size());
  if (place + sizeof number <= bytes.size()) std::memcpy(&number, bytes.data() + place, sizeof number);
  return number;
}

TEST(LiveServer, AnswersByHttp) {
  Live live;
  const auto scene = get(live.port(), "/scene");
  EXPECT_EQ(scene.result(), http::status::ok);
  const Json told = Json::parse(scene.body());
  EXPECT_EQ(told["format"], "mimbre-live-1");
  EXPECT_EQ(told["inputs"].size(), live.inputs().size());
  EXPECT_FALSE(told["bodies"].empty());
  EXPECT_TRUE(told["animation"].contains("positions"));
  const Json status = Json::parse(get(live.port(), "/status").body());
  EXPECT_EQ(status["state"], "running");
  EXPECT_TRUE(status["computation"].contains("p9999"));
  EXPECT_EQ(status["histogram"]["edges"].size(), status["histogram"]["computation"].size() + 1);
  EXPECT_EQ(get(live.port(), "/nothing").result(), http::status::not_found);
  EXPECT_EQ(get(live.port(), "/status", {}, http::verb::delete_).result(), http::status::method_not_allowed);
  const auto head = get(live.port(), "/status", {}, http::verb::head);
  EXPECT_EQ(head.result(), http::status::ok);
  EXPECT_TRUE(head.body().empty());
}

TEST(LiveServer, OtherNamesAndOriginsAreRefused) {
  Live live;
  const std::string here = "http://127.0.0.1:" + std::to_string(live.port());
  EXPECT_EQ(get(live.port(), "/status", {{"Host", "evil.example"}}).result(), http::status::forbidden);
  EXPECT_EQ(get(live.port(), "/status", {{"Origin", "http://evil.example"}}).result(),
            http::status::forbidden);
  EXPECT_EQ(get(live.port(), "/status", {{"Origin", "null"}}).result(), http::status::forbidden);
  EXPECT_EQ(get(live.port(), "/status", {{"Origin", here}}).result(), http::status::ok);
  EXPECT_THROW(Viewer(live.port(), "/ws", "http://evil.example"), beast::system_error);
  EXPECT_THROW(Viewer(live.port(), "/elsewhere"), beast::system_error);
  EXPECT_NO_THROW(Viewer(live.port(), "/ws", here));
}

TEST(LiveServer, ATokenIsNeededWhereThereIsOne) {
  Live live("se-cret");
  EXPECT_THAT(live.url(), HasSubstr("?token=se-cret"));
  for (const char* wrong : {"/status", "/status?token=", "/status?token=se-cre", "/status?token=se-cret2",
                            "/status?nottoken=se-cret"})
    EXPECT_EQ(get(live.port(), wrong).result(), http::status::forbidden) << wrong;
  EXPECT_EQ(get(live.port(), "/status?token=se-cret").result(), http::status::ok);
  EXPECT_EQ(get(live.port(), "/status?a=b&token=se-cret").result(), http::status::ok);
  EXPECT_THROW(Viewer(live.port(), "/ws"), beast::system_error);
  EXPECT_NO_THROW(Viewer(live.port(), "/ws?token=se-cret"));
}

TEST(LiveServer, PicturesHaveWhatWasChosen) {
  Live live;
  Viewer viewer(live.port());
  viewer.say({{"do", "channels"}, {"indices", {1, 0}}});
  const Json said = viewer.until("channels");
  EXPECT_EQ(said["choice"], 1);
  for (int k = 0; k < 10'000; ++k) {
    const std::string p = viewer.picture();
    ASSERT_EQ(number_at<std::uint8_t>(p, 0), 1);
    const auto n = number_at<std::uint16_t>(p, 2);
    const auto m = number_at<std::uint32_t>(p, 4);
    EXPECT_EQ(m, live.inputs().size());
    if (number_at<std::uint32_t>(p, 36) != 1) continue;
    ASSERT_EQ(n, 2);
    // 40 bytes of heading; bodies of 40 bytes, no modes.
    const std::size_t bodies = (p.size() - 40 - 4 * (n + m)) / 40;
    EXPECT_EQ(p.size(), 40 + 40 * bodies + 4 * (n + m));
    const std::size_t values = 40 + 40 * bodies;
    if (std::isfinite(number_at<float>(p, values)) && number_at<double>(p, 8) > 0) return;
  }
  ADD_FAILURE() << "no picture had the channels that were chosen";
}

TEST(LiveServer, OneViewerHasControl) {
  Live live;
  Viewer first(live.port()), second(live.port());
  EXPECT_FALSE(first.hello["control"]);
  second.say({{"do", "pause"}});
  EXPECT_THAT(second.until("error")["message"].get<std::string>(), HasSubstr("in control"));
  first.say({{"do", "control"}, {"take", true}});
  while (!first.until("control")["yours"]) {
  }
  second.say({{"do", "control"}, {"take", true}});
  EXPECT_THAT(second.until("error")["message"].get<std::string>(), HasSubstr("another viewer"));
  EXPECT_EQ(first.until("asked")["viewer"], second.hello["viewer"]);
  first.say({{"do", "pause"}});
  EXPECT_TRUE(comes_true([&] { return live.loop().state() == RealTimeLoop::State::paused; }));
  // Who vanishes gives it back.
  first.socket().next_layer().close();
  while (second.until("control")["taken"]) {
  }
  second.say({{"do", "control"}, {"take", true}});
  while (!second.until("control")["yours"]) {
  }
  second.say({{"do", "resume"}});
  EXPECT_TRUE(comes_true([&] { return live.loop().state() == RealTimeLoop::State::running; }));
}

TEST(LiveServer, InputsAreSetToldAndPlayed) {
  Live live;
  Viewer viewer(live.port());
  viewer.say({{"do", "control"}, {"take", true}});
  while (!viewer.until("control")["yours"]) {
  }
  const std::string name = live.inputs()[0].name;
  const double wanted = std::min(live.inputs()[0].max, live.inputs()[0].start + 0.125);
  viewer.say({{"do", "inputs"}, {"values", {{name, wanted}}}});
  EXPECT_TRUE(comes_true([&] {
    const Json values = Json::parse(get(live.port(), "/inputs").body())["tracks"][name]["values"];
    return !values.empty() && values.back() == wanted;
  }));
  viewer.say({{"do", "play"},
              {"tracks", {{name, {{"times", {0, 0.02}}, {"values", {live.inputs()[0].start, wanted}}}}}}});
  EXPECT_TRUE(viewer.until("played")["on"]);
  EXPECT_FALSE(viewer.until("played")["on"]);
  EXPECT_TRUE(comes_true([&] {
    const Json values = Json::parse(get(live.port(), "/inputs").body())["tracks"][name]["values"];
    return values.size() >= 4 && values[values.size() - 2] == live.inputs()[0].start &&
           values.back() == wanted;
  }));
}

/// Within one step, before the server looks: its viewers are told all the same.
TEST(LiveServer, WhatIsPlayedInAMomentIsTold) {
  Live live;
  Viewer viewer(live.port());
  viewer.say({{"do", "control"}, {"take", true}});
  while (!viewer.until("control")["yours"]) {
  }
  const spec::Input& input = live.inputs()[0];
  for (int k = 0; k < 5; ++k) {
    viewer.say({{"do", "play"}, {"tracks", {{input.name, {{"times", {0}}, {"values", {input.start}}}}}}});
    EXPECT_TRUE(viewer.until("played")["on"]);
    EXPECT_FALSE(viewer.until("played")["on"]);
  }
}

TEST(LiveServer, SnapshotsHaveNames) {
  Live live;
  Viewer viewer(live.port());
  viewer.say({{"do", "control"}, {"take", true}});
  while (!viewer.until("control")["yours"]) {
  }
  viewer.say({{"do", "restore"}, {"name", "none"}});
  EXPECT_THAT(viewer.until("error")["message"].get<std::string>(), HasSubstr("no snapshot 'none'"));
  viewer.say({{"do", "pause"}});
  ASSERT_TRUE(comes_true([&] { return live.loop().state() == RealTimeLoop::State::paused; }));
  const double time = live.loop().time();
  viewer.say({{"do", "snapshot"}, {"name", "here <b>"}});
  EXPECT_EQ(viewer.until("snapshots")["names"], Json({"here <b>"}));
  viewer.say({{"do", "resume"}});
  ASSERT_TRUE(comes_true([&] { return live.loop().time() > time + 0.05; }));
  viewer.say({{"do", "pause"}});
  viewer.say({{"do", "restore"}, {"name", "here <b>"}});
  EXPECT_TRUE(comes_true([&] { return live.loop().time() == time; }));
}

/// What was set before a reset and not taken yet is gone with it; what is set after it counts.
TEST(LiveServer, InputsAreAtTheirStartAfterAReset) {
  Live live;
  Viewer viewer(live.port());
  viewer.say({{"do", "control"}, {"take", true}});
  while (!viewer.until("control")["yours"]) {
  }
  const std::string name = live.inputs()[0].name;
  const double start = live.inputs()[0].start;
  const auto set_to = [&](double value) { viewer.say({{"do", "inputs"}, {"values", {{name, value}}}}); };
  const auto reset = [&] {
    viewer.say({{"do", "reset"}});
    ASSERT_TRUE(comes_true([&] { return live.loop().time() == 0; }));
  };
  const auto begins_with = [&](double value) {
    viewer.say({{"do", "resume"}});
    ASSERT_TRUE(comes_true([&] { return live.loop().time() > 0.1; })) << live.loop().message();
    EXPECT_EQ(Json::parse(get(live.port(), "/inputs").body())["tracks"][name]["values"].back(), value);
    viewer.say({{"do", "pause"}});
    ASSERT_TRUE(comes_true([&] { return live.loop().state() == RealTimeLoop::State::paused; }));
  };
  viewer.say({{"do", "pause"}});
  ASSERT_TRUE(comes_true([&] { return live.loop().state() == RealTimeLoop::State::paused; }));
  set_to(1e200);
  reset();
  begins_with(start);
  set_to(1e200);
  viewer.say({{"do", "resume"}});
  ASSERT_TRUE(comes_true([&] { return live.loop().state() == RealTimeLoop::State::failed; }));
  set_to(-1e200);
  viewer.say({{"do", "pause"}});  // of no effect: it has failed
  viewer.say({{"do", "reset"}});
  ASSERT_TRUE(comes_true([&] { return live.loop().state() == RealTimeLoop::State::running; }));
  viewer.say({{"do", "pause"}});
  ASSERT_TRUE(comes_true([&] { return live.loop().state() == RealTimeLoop::State::paused; }));
  EXPECT_EQ(Json::parse(get(live.port(), "/inputs").body())["tracks"][name]["values"].back(), start);
  set_to(1e200);
  reset();
  set_to(start + 0.125);
  begins_with(start + 0.125);
}

/// Words that are none, deep and long ones, numbers that are none: each is answered, and a viewer that says
/// nothing else is sent away.
TEST(LiveServer, NonsenseIsAnsweredAndThenSentAway) {
  Live live;
  Viewer viewer(live.port());
  const std::vector<std::string> nonsense{"",
                                          "{",
                                          "[]",
                                          "7",
                                          "{\"do\":7}",
                                          "{\"do\":\"fly\"}",
                                          "{\"do\":\"channels\",\"indices\":[-1]}",
                                          "{\"do\":\"channels\",\"indices\":[1e300]}",
                                          "{\"do\":\"inputs\",\"values\":{\"none\":1}}",
                                          std::string(5000, '['),
                                          "{\"do\":\"control\",\"take\":\"yes\"}",
                                          "\xff\xfe"};
  int errors = 0;
  try {
    for (int k = 0; k < 200; ++k) {
      viewer.socket().binary(true);
      viewer.socket().write(asio::buffer(nonsense[static_cast<std::size_t>(k) % nonsense.size()]));
      viewer.until("error");
      ++errors;
    }
  } catch (const beast::system_error&) {
  }
  EXPECT_GE(errors, 98);
  EXPECT_LE(errors, 100);
  EXPECT_EQ(live.loop().state(), RealTimeLoop::State::running);
}

/// Connections that say rubbish, half a request, nothing, or read nothing: others are served, and the loop
/// goes on.
TEST(LiveServer, RubbishDoesNotHarmOthers) {
  Live live;
  std::mt19937 random(5);
  std::vector<std::unique_ptr<Wire>> idle;
  const std::string request =
      "GET /scene HTTP/1.1\r\nHost: 127.0.0.1:" + std::to_string(live.port()) + "\r\n\r\n";
  for (int k = 0; k < 20; ++k) {
    idle.push_back(std::make_unique<Wire>(live.port()));
    idle.back()->send(k % 2 ? request : request.substr(0, 30));
  }
  for (int k = 0; k < 300; ++k) {
    Wire wire(live.port());
    std::string bytes = request;
    switch (k % 5) {
      case 0:
        for (char& c : bytes) c = static_cast<char>(random());
        break;
      case 1:
        bytes.insert(bytes.size() - 4, "X: " + std::string(20'000, 'x'));
        break;
      case 2:
        bytes[random() % bytes.size()] = static_cast<char>(random());
        break;
      case 3:
        bytes = "GET /ws HTTP/1.1\r\nHost: 127.0.0.1:" + std::to_string(live.port()) +
                "\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
                "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n";
        for (int j = 0; j < 200; ++j) bytes += static_cast<char>(random());
        break;
      default:
        bytes.resize(random() % bytes.size());
    }
    wire.send(bytes);
  }
  // Before it has seen that the others have gone, there may be too many.
  EXPECT_TRUE(comes_true([&] {
    try {
      return get(live.port(), "/status").result() == http::status::ok;
    } catch (const beast::system_error&) {
      return false;
    }
  }));
  const std::int64_t steps = live.loop().monitor().steps;
  EXPECT_TRUE(comes_true([&] { return live.loop().monitor().steps > steps + 10; }));
}

/// Connections that ask nothing, or half of it, or do not read the answer, make room for those that do.
TEST(LiveServer, HalfOpenConnectionsKeepNobodyOut) {
  Live live;
  const std::string request =
      "GET /scene HTTP/1.1\r\nHost: 127.0.0.1:" + std::to_string(live.port()) + "\r\n\r\n";
  std::vector<std::unique_ptr<Wire>> idle;
  for (int k = 0; k < 200; ++k) {
    idle.push_back(std::make_unique<Wire>(live.port()));
    if (k % 3 > 0) idle.back()->send(k % 3 == 1 ? request : request.substr(0, 30));
  }
  for (int k = 0; k < 20; ++k) EXPECT_EQ(get(live.port(), "/status").result(), http::status::ok);
  Viewer viewer(live.port());
  EXPECT_EQ(viewer.hello["say"], "hello");
  // The first have been sent away, the last are still there.
  std::string rest;
  boost::system::error_code error;
  char byte = 0;
  asio::read(idle.front()->socket(), asio::buffer(&byte, 1), error);
  EXPECT_TRUE(error);
  idle.back()->send("GET /status HTTP/1.1\r\nHost: 127.0.0.1:" + std::to_string(live.port()) + "\r\n\r\n");
}

TEST(LiveServer, AViewerThatReadsNothingHoldsUpNobody) {
  Live live;
  Viewer still(live.port());
  Viewer viewer(live.port());
  for (int k = 0; k < 100; ++k) viewer.picture();
  const std::int64_t steps = live.loop().monitor().steps;
  EXPECT_TRUE(comes_true([&] { return live.loop().monitor().steps > steps + 10; }));
}

TEST(LiveServer, SaysWhereItCannotListen) {
  Simulation simulation = simulation_of(controlled_four_bar(), Formulation::relative, 0.005);
  RealTimeLoop loop(simulation, {});
  const LiveServer server(simulation, loop, {});
  EXPECT_THROW(LiveServer(simulation, loop, {"127.0.0.1", server.port(), "", nullptr}), std::runtime_error);
  EXPECT_THROW(LiveServer(simulation, loop, {"localhost", 0, "", nullptr}), InputError);
  EXPECT_THROW(LiveServer(simulation, loop, {"127.0.0.1", 0, "a b&c", nullptr}), InputError);
  EXPECT_THROW(LiveServer(simulation, loop, {"127.0.0.1", 70000, "", nullptr}), InputError);
}

}  // namespace
}  // namespace mimbre::test::live_server_test
