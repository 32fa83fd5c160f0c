#include "mimbre/live_server.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <cctype>
#include <chrono>
#include <deque>
#include <iterator>
#include <list>
#include <random>
#include <stdexcept>
#include <thread>
#include <utility>

#include "live/live_page.h"
#include "live/messages.h"
#include "live/picture.h"
#include "mimbre/diagnostics.h"

namespace mimbre {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using tcp = asio::ip::tcp;
using boost::system::error_code;
using namespace std::chrono_literals;

constexpr std::size_t most_connections = 128, most_viewers = 32;
constexpr std::size_t header_bytes = 8 * 1024, viewer_bytes = 64 * 1024, control_bytes = 8 * 1024 * 1024;
constexpr std::size_t most_waiting_texts = 64;
constexpr int most_errors = 100;
constexpr std::chrono::milliseconds request_time = 10s, answer_time = 60s, picture_period = 16ms,
                                    status_period = 500ms, retry_period = 100ms;
constexpr std::size_t longest_history = 1'000'000;

std::string random_token() {
  std::random_device device;
  std::string token;
  for (int k = 0; k < 4; ++k) token += fmt::format("{:08x}", device());
  return token;
}

/// Takes as long whatever they have in common.
bool same_secret(std::string_view given, std::string_view wanted) {
  unsigned difference = static_cast<unsigned>(given.size() != wanted.size());
  for (std::size_t k = 0; k < wanted.size(); ++k)
    difference |= static_cast<unsigned>(static_cast<unsigned char>(k < given.size() ? given[k] : 0) ^
                                        static_cast<unsigned char>(wanted[k]));
  return difference == 0;
}

/// The value of a name in "/path?name=value&…".
std::string_view query(std::string_view target, std::string_view name) {
  std::size_t at = target.find('?');
  while (at != std::string_view::npos) {
    const std::size_t begin = at + 1;
    at = target.find('&', begin);
    const std::string_view one = target.substr(begin, at == std::string_view::npos ? at : at - begin);
    if (one.starts_with(name) && one.size() > name.size() && one[name.size()] == '=')
      return one.substr(name.size() + 1);
  }
  return {};
}

std::string_view as_view(beast::string_view text) { return {text.data(), text.size()}; }

/// What viewers and the server have in common; of the server's thread alone.
struct Session;
class Connection;

/// One viewer. Texts wait for each other; a picture that cannot be sent at once is left out.
class Viewer : public std::enable_shared_from_this<Viewer> {
 public:
  Viewer(beast::tcp_stream&& stream, Session& session, int number);
  ~Viewer();
  Viewer(const Viewer&) = delete;
  Viewer& operator=(const Viewer&) = delete;

  void accept(const http::request<http::empty_body>& request);
  void enqueue(std::string text);
  void show(const live::Picture& picture, live::PictureMarks marks);
  void control(bool has);
  void close();
  int number() const { return number_; }
  const std::vector<int>& channels() const { return channels_; }

 private:
  void read();
  void hear(const std::string& text);
  void send();
  void leave();

  websocket::stream<beast::tcp_stream> socket_;
  Session& session_;
  const int number_;
  beast::flat_buffer heard_;
  std::deque<std::string> texts_;  ///< the first is being sent, when sending_ a text
  std::string picture_;
  bool sending_ = false, sending_text_ = false, here_ = false;
  std::vector<int> channels_;
  std::uint32_t choice_ = 0;
  int errors_ = 0;
};

struct Session {
  Session(Simulation& simulation, RealTimeLoop& of, RealTimeRecorder* recording)
      : loop(of),
        recorder(recording),
        inputs(simulation.inputs()),
        channel_count(static_cast<int>(simulation.channels().size())),
        board(simulation),
        pictures(simulation, loop.step() / loop.options().speed),
        scene(std::make_shared<const std::string>(live::scene_text(simulation, loop, recorder))),
        histories(inputs.size()),
        shown(live::shown_at_first(simulation)) {}

  void enter(const std::shared_ptr<Viewer>& viewer) {
    viewers.push_back(viewer);
    viewer->enqueue(live::hello_text(viewer->number(), controller == viewer.get(), viewer->channels()));
    viewer->enqueue(live::control_text(controller == viewer.get(), controller != nullptr));
    viewer->enqueue(live::snapshots_text(snapshots));
    viewer->enqueue(live::status_text(loop, recorder, viewers.size(), true));
    choose();
  }

  void leave(const Viewer* viewer) {
    std::erase_if(viewers, [&](const auto& one) { return one.get() == viewer; });
    if (controller == viewer) {
      controller = nullptr;
      tell_control();
    }
    choose();
  }

  void take_control(Viewer& viewer, bool take) {
    if (take && controller && controller != &viewer) {
      controller->enqueue(live::asked_text(viewer.number()));
      throw InputError(Mark{}, "another viewer has control; it has to release it first");
    }
    if (!take && controller != &viewer) throw InputError(Mark{}, "this viewer has no control to release");
    controller = take ? &viewer : nullptr;
    tell_control();
  }

  // A viewer that cannot be reached leaves: they are gone through in a copy.
  void tell_control() {
    const auto all = viewers;
    for (const auto& one : all) {
      one->control(one.get() == controller);
      one->enqueue(live::control_text(one.get() == controller, controller != nullptr));
    }
  }

  /// All that the viewers want together.
  void choose() {
    live::Choice choice;
    for (const auto& viewer : viewers)
      for (const int channel : viewer->channels()) {
        const auto end = choice.channels.begin() + choice.count;
        if (choice.count < live::Choice::most && std::find(choice.channels.begin(), end, channel) == end)
          choice.channels[static_cast<std::size_t>(choice.count++)] = channel;
      }
    pictures.choose(choice);
  }

  void tell_all(const std::string& text) {
    const auto all = viewers;
    for (const auto& viewer : all) viewer->enqueue(text);
  }

  /// What the viewer in control asks for.
  void act(live::Asked& asked) {
    const auto request = [&](RealTimeRequest::Kind kind, int place = 0) {
      if (!loop.request({kind, place})) throw InputError(Mark{}, "too many requests at once");
    };
    using Kind = RealTimeRequest::Kind;
    const std::string& what = asked.what;
    if (what == "inputs") {
      for (const auto& [input, value] : asked.values) board.set(input, value);
    } else if (what == "pause") {
      request(Kind::pause);
    } else if (what == "resume") {
      request(Kind::resume);
    } else if (what == "step") {
      request(Kind::step);
    } else if (what == "reset") {
      board.drop();
      request(Kind::reset);
    } else if (what == "snapshot") {
      request(Kind::save, keep(asked.name));
      tell_all(live::snapshots_text(snapshots));
    } else if (what == "restore") {
      const auto found = std::find(snapshots.begin(), snapshots.end(), asked.name);
      if (found == snapshots.end())
        throw InputError(Mark{}, fmt::format("there is no snapshot '{}'", asked.name));
      board.drop();
      request(Kind::restore, places[static_cast<std::size_t>(found - snapshots.begin())]);
    } else if (what == "record") {
      if (!recorder) throw InputError(Mark{}, "there is no file to record to: mimbre live --record FILE.h5");
      recorder->record(asked.on);
      tell_all(live::recording_text(recorder->recording(), recorder->path()));
    } else if (what == "play") {
      if (!board.play(asked.tracks ? std::make_unique<live::InputTracks>(std::move(*asked.tracks)) : nullptr))
        throw InputError(Mark{}, "too many requests at once");
    }
  }

  /// A place for a snapshot of that name; the oldest goes where there is none.
  int keep(const std::string& name) {
    const int most = loop.options().snapshots;
    if (most == 0) throw InputError(Mark{}, "there are no places for snapshots");
    int place = static_cast<int>(snapshots.size());
    auto old = std::find(snapshots.begin(), snapshots.end(), name);
    if (old == snapshots.end() && place == most) old = snapshots.begin();
    if (old != snapshots.end()) {
      const auto at = old - snapshots.begin();
      place = places[static_cast<std::size_t>(at)];
      snapshots.erase(old);
      places.erase(places.begin() + at);
    }
    snapshots.push_back(name);
    places.push_back(place);
    return place;
  }

  /// What was set since the simulation was put where it began.
  void note_inputs() {
    board.tidy();
    while (const live::InputChange* change = board.change()) {
      if (change->input < 0) {
        for (live::InputHistory& history : histories) history = {};
      } else {
        live::InputHistory& history = histories[static_cast<std::size_t>(change->input)];
        if (history.times.size() < longest_history) {
          history.times.push_back(change->time);
          history.values.push_back(change->value);
        }
      }
      board.pop_change();
    }
    const std::uint32_t now_played = board.played();
    const bool still = board.playing();
    if (now_played != played) tell_playing(true);  // though it may be over
    played = now_played;
    tell_playing(still);
  }

  void tell_playing(bool on) {
    if (playing == on) return;
    playing = on;
    tell_all(live::played_text(on));
  }

  void show() {
    bool news = false;
    const live::Picture& picture = pictures.read(news);
    if (!news) return;
    live::PictureMarks marks;
    const RealTimeLoop::State state = loop.state();
    marks.paused = state == RealTimeLoop::State::paused;
    marks.failed = state == RealTimeLoop::State::failed;
    marks.ended = state == RealTimeLoop::State::ended;
    marks.recording = recorder && recorder->recording();
    marks.playing = playing;
    for (const auto& viewer : viewers) {
      marks.control = viewer.get() == controller;
      viewer->show(picture, marks);
    }
  }

  RealTimeLoop& loop;
  RealTimeRecorder* const recorder;
  const std::vector<spec::Input> inputs;
  const int channel_count;
  live::InputBoard board;
  live::PictureMaker pictures;
  const std::shared_ptr<const std::string> scene;
  std::vector<live::InputHistory> histories;
  const std::vector<int> shown;  ///< at first
  std::uint32_t played = 0;      ///< of the board, as viewers know it
  bool playing = false;

  std::vector<std::shared_ptr<Viewer>> viewers;
  Viewer* controller = nullptr;
  std::vector<std::string> snapshots;  ///< newest last
  std::vector<int> places;             ///< of theirs
  int next_viewer = 1;
  std::list<Connection*> connections;  ///< the one that has waited longest for a request or an answer first
  std::size_t seats = 0;               ///< viewers, and those who are about to be
};

Viewer::Viewer(beast::tcp_stream&& stream, Session& session, int number)
    : socket_(std::move(stream)), session_(session), number_(number) {
  ++session_.seats;
}
Viewer::~Viewer() { --session_.seats; }

void Viewer::accept(const http::request<http::empty_body>& request) {
  channels_ = session_.shown;
  beast::get_lowest_layer(socket_).expires_never();
  websocket::stream_base::timeout timeout =
      websocket::stream_base::timeout::suggested(beast::role_type::server);
  timeout.idle_timeout = 30s;
  timeout.keep_alive_pings = true;
  socket_.set_option(timeout);
  socket_.read_message_max(viewer_bytes);
  socket_.set_option(websocket::stream_base::decorator([](websocket::response_type& response) {
    response.set(http::field::server, "mimbre");
    response.set(http::field::sec_websocket_protocol, "mimbre-live-1");
  }));
  socket_.async_accept(request, [self = shared_from_this()](error_code error) {
    if (error) return self->leave();
    self->here_ = true;
    self->session_.enter(self);
    self->read();
  });
}

void Viewer::read() {
  socket_.async_read(heard_, [self = shared_from_this()](error_code error, std::size_t) {
    if (error) return self->leave();
    if (self->socket_.got_text())
      self->hear(beast::buffers_to_string(self->heard_.data()));
    else
      self->hear("");
    self->heard_.consume(self->heard_.size());
    // What a long message took is given back.
    if (self->heard_.capacity() > viewer_bytes) self->heard_.shrink_to_fit();
    if (self->here_) self->read();
  });
}

void Viewer::hear(const std::string& text) {
  try {
    live::Asked asked = live::understood(text, session_.inputs, session_.channel_count);
    if (asked.what == "channels") {
      channels_ = asked.channels;
      ++choice_;
      session_.choose();
      return enqueue(live::channels_text(channels_, choice_));
    }
    if (asked.what == "control") return session_.take_control(*this, asked.on);
    if (session_.controller != this)
      throw InputError(Mark{}, fmt::format("'{}' is for the viewer in control", asked.what));
    session_.act(asked);
  } catch (const std::exception& error) {
    enqueue(live::error_text(error.what()));
    if (++errors_ >= most_errors) close();
  }
}

void Viewer::enqueue(std::string text) {
  if (!here_) return;
  if (texts_.size() >= most_waiting_texts) return close();
  texts_.push_back(std::move(text));
  send();
}

void Viewer::show(const live::Picture& picture, live::PictureMarks marks) {
  if (!here_ || sending_ || !texts_.empty()) return;
  marks.choice = choice_;
  picture_ = live::encoded(picture, channels_, marks);
  send();
}

void Viewer::send() {
  if (sending_ || !here_ || (texts_.empty() && picture_.empty())) return;
  sending_ = true;
  sending_text_ = !texts_.empty();
  socket_.text(sending_text_);
  socket_.async_write(asio::buffer(sending_text_ ? texts_.front() : picture_),
                      [self = shared_from_this()](error_code error, std::size_t) {
                        self->sending_ = false;
                        if (error) return self->leave();
                        if (self->sending_text_)
                          self->texts_.pop_front();
                        else
                          self->picture_.clear();
                        self->send();
                      });
}

void Viewer::control(bool has) { socket_.read_message_max(has ? control_bytes : viewer_bytes); }

void Viewer::close() {
  error_code ignored;
  beast::get_lowest_layer(socket_).socket().close(ignored);
  leave();
}

void Viewer::leave() {
  if (!here_) return;
  here_ = false;
  session_.leave(this);
}

/// Who may ask for what.
struct Guard {
  std::string token, own;  ///< own: the address that is listened at
  bool loopback = true;
  int port = 0;

  bool allows_host(std::string_view host) const {
    if (!loopback) return true;  // whatever name this machine has there; the token decides
    const std::string number = fmt::format(":{}", port);
    for (const std::string& name :
         {std::string("127.0.0.1"), std::string("localhost"), std::string("[::1]"), own})
      if (host == name + number || (port == 80 && host == name)) return true;
    return false;
  }
  /// Pages of other places may not; other programs send no origin.
  static bool allows_origin(std::string_view origin, std::string_view host) {
    return origin.empty() || origin == "http://" + std::string(host) ||
           origin == "https://" + std::string(host);
  }
  bool allows_token(std::string_view target) const {
    return token.empty() || same_secret(query(target, "token"), token);
  }
};

/// A connection, until it is a viewer's or has its answers.
class Connection : public std::enable_shared_from_this<Connection> {
 public:
  Connection(tcp::socket&& socket, Session& session, const Guard& guard)
      : stream_(std::move(socket)), session_(session), guard_(guard) {
    session_.connections.push_back(this);
    place_ = std::prev(session_.connections.end());
  }
  ~Connection() { leave(); }
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  /// Makes room for another.
  void evict() {
    leave();
    stream_.close();
  }

  void read() {
    begin_wait();
    parser_.emplace();
    parser_->header_limit(header_bytes);
    parser_->body_limit(0);
    stream_.expires_after(request_time);
    http::async_read(stream_, buffer_, *parser_, [self = shared_from_this()](error_code error, std::size_t) {
      if (error == http::error::header_limit || error == http::error::body_limit)
        return self->refuse(http::status::payload_too_large, "the request is too long");
      if (error && error.category() == make_error_code(http::error::bad_method).category() &&
          error != http::error::end_of_stream && error != http::error::partial_message)
        return self->refuse(http::status::bad_request, "the request is malformed");
      if (!error) self->answer();
    });
  }

 private:
  void leave() {
    if (std::exchange(listed_, false)) session_.connections.erase(place_);
  }
  void begin_wait() {
    if (listed_) session_.connections.splice(session_.connections.end(), session_.connections, place_);
  }

  void answer() {
    const auto& request = parser_->get();
    const std::string_view target = as_view(request.target()), host = as_view(request[http::field::host]);
    const std::string_view path = target.substr(0, target.find('?'));
    keep_alive_ = request.keep_alive();
    if (!guard_.allows_host(host)) return refuse(http::status::forbidden, "the host is not this server's");
    if (!guard_.allows_origin(as_view(request[http::field::origin]), host))
      return refuse(http::status::forbidden, "pages of other origins are refused");
    if (!guard_.allows_token(target)) return refuse(http::status::forbidden, "the token is wrong or missing");
    if (websocket::is_upgrade(request)) {
      if (path != "/ws") return refuse(http::status::not_found, "the WebSocket is at /ws");
      if (session_.seats >= most_viewers)
        return refuse(http::status::service_unavailable, "there are too many viewers");
      stream_.expires_never();
      std::make_shared<Viewer>(std::move(stream_), session_, session_.next_viewer++)->accept(request);
      return;
    }
    if (request.method() != http::verb::get && request.method() != http::verb::head)
      return refuse(http::status::method_not_allowed, "there are only GET and HEAD");
    head_ = request.method() == http::verb::head;
    if (path == "/") {
      const std::string_view page = live::live_page();
      if (page.empty()) return refuse(http::status::not_found, "this mimbre was built without its live page");
      return send(http::status::ok, "text/html; charset=utf-8", std::make_shared<std::string>(page));
    }
    if (path == "/scene") return send(http::status::ok, "application/json", session_.scene);
    if (path == "/status")
      return send(http::status::ok, "application/json",
                  std::make_shared<std::string>(
                      live::status_text(session_.loop, session_.recorder, session_.viewers.size(), false)));
    if (path == "/inputs")
      return send(http::status::ok, "application/json",
                  std::make_shared<std::string>(live::inputs_text(session_.inputs, session_.histories)));
    refuse(http::status::not_found, "there is no such page here");
  }

  void refuse(http::status status, const std::string& why) {
    keep_alive_ = false;
    send(status, "text/plain; charset=utf-8", std::make_shared<std::string>(why + "\n"));
  }

  void send(http::status status, const char* type, std::shared_ptr<const std::string> text) {
    using Body = http::span_body<const char>;
    auto response = std::make_shared<http::response<Body>>(status, 11);
    response->set(http::field::server, "mimbre");
    response->set(http::field::content_type, type);
    response->set(http::field::cache_control, "no-store");
    response->set("X-Content-Type-Options", "nosniff");
    response->set(
        "Content-Security-Policy",
        "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:; "
        "media-src blob:; connect-src 'self'; frame-ancestors 'none'; base-uri 'none'; form-action 'none'");
    response->set("Referrer-Policy", "no-referrer");
    response->keep_alive(keep_alive_);
    if (head_) {
      response->content_length(text->size());
    } else {
      response->body() = {text->data(), text->size()};
      response->prepare_payload();
    }
    begin_wait();
    stream_.expires_after(answer_time);
    auto serializer = std::make_shared<http::response_serializer<Body>>(*response);
    serializer->split(head_);
    const auto done = [self = shared_from_this(), response, text, serializer](error_code error, std::size_t) {
      if (error) return;
      if (self->keep_alive_) return self->read();
      error_code ignored;
      self->stream_.socket().shutdown(tcp::socket::shutdown_send, ignored);
    };
    if (head_)
      http::async_write_header(stream_, *serializer, done);
    else
      http::async_write(stream_, *serializer, done);
  }

  beast::tcp_stream stream_;
  Session& session_;
  const Guard& guard_;
  beast::flat_buffer buffer_{header_bytes + 1024};
  std::optional<http::request_parser<http::empty_body>> parser_;
  bool keep_alive_ = false, head_ = false;
  std::list<Connection*>::iterator place_;
  bool listed_ = true;
};

}  // namespace

struct LiveServer::Impl {
  Impl(Simulation& simulation, RealTimeLoop& loop, const LiveServerOptions& options)
      : session(simulation, loop, options.recorder), acceptor(context), pictures(context), statuses(context) {
    error_code error;
    const asio::ip::address address = asio::ip::make_address(options.address, error);
    if (error)
      throw InputError(Mark{}, fmt::format("'{}' is no address of an interface, like 127.0.0.1 or 0.0.0.0",
                                           options.address));
    for (const char c : options.token)
      if (!std::isalnum(static_cast<unsigned char>(c)) &&
          std::string_view("._~-").find(c) == std::string_view::npos)
        throw InputError(Mark{}, "a token has letters, digits and . _ ~ - only: it stands in an address");
    if (options.port < 0 || options.port > 65535)
      throw InputError(Mark{}, fmt::format("the port is {}; it must be 0 to 65535", options.port));
    try {
      const tcp::endpoint end(address, static_cast<unsigned short>(options.port));
      acceptor.open(end.protocol());
      acceptor.set_option(asio::socket_base::reuse_address(true));
      acceptor.bind(end);
      acceptor.listen();
    } catch (const std::exception& failure) {
      throw std::runtime_error(
          fmt::format("cannot listen at {} port {}: {}", options.address, options.port, failure.what()));
    }
    guard.port = acceptor.local_endpoint().port();
    guard.loopback = address.is_loopback();
    guard.token = options.token.empty() && !guard.loopback ? random_token() : options.token;
    host = address.is_v6() ? "[" + address.to_string() + "]" : address.to_string();
    guard.own = host;
    loop.add(session.board);
    loop.add(session.pictures);
    accept();
    show();
    report_status();
    thread = std::thread([this] { serve(); });
  }

  ~Impl() {
    asio::post(context, [this] {
      ending = true;
      error_code ignored;
      acceptor.close(ignored);
      pictures.cancel();
      statuses.cancel();
      // They end their reading and go.
      const auto viewers = session.viewers;
      for (const auto& viewer : viewers) viewer->close();
      context.stop();
    });
    thread.join();
  }

  void serve() {
    // A viewer that makes the server run out of something costs that viewer, not the others.
    while (!ending) {
      try {
        context.run();
        return;
      } catch (const std::exception&) {
      }
    }
  }

  void accept() {
    acceptor.async_accept([this](error_code error, tcp::socket socket) {
      if (ending) return;
      if (!error) {
        error_code ignored;
        socket.set_option(tcp::no_delay(true), ignored);
        // Who connects and does not ask keeps nobody out.
        if (session.connections.size() >= most_connections) session.connections.front()->evict();
        std::make_shared<Connection>(std::move(socket), session, guard)->read();
        return accept();
      }
      // Out of files, for example: it may pass.
      auto later = std::make_shared<asio::steady_timer>(context, retry_period);
      later->async_wait([this, later](error_code) {
        if (!ending) accept();
      });
    });
  }

  void show() {
    pictures.expires_after(picture_period);
    pictures.async_wait([this](error_code error) {
      if (error || ending) return;
      session.note_inputs();
      session.show();
      show();
    });
  }

  void report_status() {
    statuses.expires_after(status_period);
    statuses.async_wait([this](error_code error) {
      if (error || ending) return;
      if (!session.viewers.empty())
        session.tell_all(live::status_text(session.loop, session.recorder, session.viewers.size(), true));
      report_status();
    });
  }

  Session session;
  Guard guard;
  asio::io_context context{1};
  tcp::acceptor acceptor;
  asio::steady_timer pictures, statuses;
  bool ending = false;  ///< of the server's thread
  std::string host;
  std::thread thread;
};

LiveServer::LiveServer(Simulation& simulation, RealTimeLoop& loop, const LiveServerOptions& options)
    : impl_(std::make_unique<Impl>(simulation, loop, options)) {}
LiveServer::~LiveServer() = default;

std::string LiveServer::url() const {
  const Guard& guard = impl_->guard;
  return fmt::format("http://{}:{}/{}", impl_->host, guard.port,
                     guard.token.empty() ? std::string() : "?token=" + guard.token);
}
int LiveServer::port() const { return impl_->guard.port; }
bool LiveServer::has_page() { return !live::live_page().empty(); }

}  // namespace mimbre
