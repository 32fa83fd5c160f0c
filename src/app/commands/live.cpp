#include <fmt/format.h>
#include <spawn.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <memory>
#include <nlohmann/json.hpp>

#include "app/advice.h"
#include "app/common.h"
#include "app/input_tables.h"
#include "app/json.h"
#include "app/method_options.h"
#include "app/summary.h"
#include "app/targets.h"
#include "app/terminal/busy.h"
#include "app/terminal/interrupts.h"
#include "app/terminal/monitor.h"
#include "app/terminal/table.h"
#include "mimbre/exchange.h"
#include "mimbre/live_server.h"

extern char** environ;

/// mimbre live: runs a model against the clock, to be looked at and driven in a browser.
namespace mimbre::app {
namespace {

struct LiveArguments {
  std::string model, address = "127.0.0.1", token, record, policy = "catch_up";
  std::vector<std::string> settings, inputs, sent, taken;
  std::string shared_memory, udp_address = "127.0.0.1";
  RunOptions method;
  std::optional<double> duration, idle;
  RealTimeOptions clock;
  double udp_wait = 0;
  int port = 0, udp = -1, most_modes = 0;
  bool open = false, no_open = false, no_lock = false, paused = false, json = false, quiet = false;
};

const std::vector<std::string> policies{"catch_up", "skip_output", "slow_down", "stop"};

std::string options_json(const LiveArguments& arguments) {
  Json json = Json::object();
  for (const auto& [name, value] : overrides(arguments.settings)) json["set"][name] = value;
  for (const std::string& input : arguments.inputs) json["input"].push_back(input);
  if (arguments.clock.speed != 1) json["speed"] = arguments.clock.speed;
  if (arguments.most_modes > 0) json["most_modes"] = arguments.most_modes;
  json.update(arguments_json(arguments.method));
  return to_text(json);
}

RealTimeOptions loop_options(const LiveArguments& a) {
  RealTimeOptions o = a.clock;
  if (a.duration) o.duration = *a.duration;
  o.overrun = static_cast<Overrun>(std::find(policies.begin(), policies.end(), a.policy) - policies.begin());
  o.lock_memory = !a.no_lock;
  o.rests_at_end = !a.duration;
  return o;
}

/// Ends the loop when the process is asked to end, and plays inputs from tables.
class Ends : public RealTimePart {
 public:
  Ends(RealTimeLoop& loop, RecordedInputs& inputs) : loop_(loop), inputs_(inputs) {}
  void before(Simulation& simulation) override { inputs_.set(simulation); }
  void timed(const StepTiming&) override { look(); }
  void rests(Simulation&) override { look(); }

 private:
  void look() {
    if (interrupted()) loop_.stop();
  }
  RealTimeLoop& loop_;
  RecordedInputs& inputs_;
};

/// Asks the desktop to show the page. False where there is none that can be asked.
bool open_in_browser(const std::string& url) {
  std::string program = "xdg-open", page = url;
  char* words[] = {program.data(), page.data(), nullptr};
  pid_t process = 0;
  return posix_spawnp(&process, program.c_str(), nullptr, nullptr, words, environ) == 0;
}

bool has_desktop() { return std::getenv("DISPLAY") || std::getenv("WAYLAND_DISPLAY"); }

std::string monitor_table(const RealTimeLoop& loop, const RealTimeMonitor* idle, const UdpExchange* udp) {
  const auto milliseconds = [](double s) { return fmt::format("{:.4f}", 1e3 * s); };
  Table table({"ms", "median", "99 %", "99.99 %", "worst"});
  const auto add = [&](const std::string& what, const Timings& t) {
    table.add({what, milliseconds(t.quantile(0.5)), milliseconds(t.quantile(0.99)),
               milliseconds(t.quantile(0.9999)), milliseconds(t.worst())});
  };
  const RealTimeMonitor& m = loop.monitor();
  add("computation, wall clock", m.computation);
  add("computation, CPU", m.cpu);
  add("latency", m.latency);
  if (udp && udp->round_trips().count() > 0) add("UDP, there and back", udp->round_trips());
  if (idle) {
    add("idle machine: computation, wall clock", idle->computation);
    add("idle machine: latency", idle->latency);
  }
  std::string text = table.text();
  text += fmt::format("{} steps of {} ms; {} overruns", m.steps.load(),
                      1e3 * loop.step() / loop.options().speed, m.overrun_count());
  for (int k = 0; k < overrun_causes; ++k)
    if (const auto count = m.overruns[static_cast<std::size_t>(k)].load())
      text += fmt::format(", {} by {}", count, name_of(static_cast<OverrunCause>(k)));
  if (idle)
    text += fmt::format("; {} of the idle machine in {} steps", idle->overrun_count(), idle->steps.load());
  const RealTimeGrants granted = loop.granted();
  text += fmt::format("\nmemory: {}; scheduling: {}; processor: {}\nworst case: {}\n", granted.memory,
                      granted.scheduling, granted.processor, loop.worst_case());
  return text;
}

void check_record(const LiveArguments& arguments, const LoadedModel& loaded,
                  const std::vector<std::string>& input_files) {
  if (arguments.record.empty()) return;
  require_not_read(arguments.model, loaded, arguments.record);
  for (const std::string& input : input_files) require_different(input, arguments.record);
  require_no_body(arguments.record);
  require_writable(arguments.record);
}

/// Measures how late the idle machine is, if asked for.
std::unique_ptr<RealTimeMonitor> watch_idle_machine(const LiveArguments& arguments, double step,
                                                    const RealTimeOptions& options) {
  if (!arguments.idle) return nullptr;
  const Busy busy("watching the idle machine", !arguments.quiet);
  auto idle = std::make_unique<RealTimeMonitor>();
  idle_loop(step / arguments.clock.speed, *arguments.idle, options, *idle);
  return idle;
}

/// The exchanges with other programs that are asked for, as parts of the loop.
struct Exchanges {
  std::unique_ptr<UdpExchange> udp;
  std::unique_ptr<SharedMemoryExchange> shared;
};

Exchanges add_exchanges(const LiveArguments& arguments, Simulation& simulation, RealTimeLoop& loop) {
  Exchanges result;
  const ExchangeOptions exchanged{arguments.sent, arguments.taken};
  if (arguments.udp >= 0) {
    result.udp = std::make_unique<UdpExchange>(
        simulation, UdpOptions{exchanged, arguments.udp_address, arguments.udp, arguments.udp_wait});
    loop.add(*result.udp);
    if (!arguments.quiet)
      fmt::print(stderr, "mimbre: note: UDP packets are taken at {} port {}\n", arguments.udp_address,
                 result.udp->port());
  }
  if (!arguments.shared_memory.empty()) {
    result.shared = std::make_unique<SharedMemoryExchange>(simulation, arguments.shared_memory, exchanged);
    loop.add(*result.shared);
  }
  return result;
}

/// Runs the loop while the page is served; the message with which it ended.
std::string serve(const LiveArguments& arguments, Simulation& simulation, RealTimeLoop& loop,
                  RealTimeRecorder* recorder) {
  LiveServer server(simulation, loop, {arguments.address, arguments.port, arguments.token, recorder});
  if (recorder) loop.add(*recorder);
  print_data(server.url() + '\n');
  if (!LiveServer::has_page()) print_warning("this mimbre was built without its live page");
  if (arguments.open || (!arguments.no_open && has_desktop() && isatty(STDOUT_FILENO)))
    if (!open_in_browser(server.url())) print_warning("no program was found that opens the page");
  catch_interrupts();
  return loop.run();
}

Json live_summary(const Simulation& simulation, const RealTimeLoop& loop, const std::string& end,
                  const RealTimeMonitor* idle, const UdpExchange* udp) {
  Json summary = answer("live", loop.state() == RealTimeLoop::State::failed ? "failed" : "ok");
  if (!end.empty()) summary["message"] = end;
  summary["time"] = simulation.time();
  summary["monitor"] = monitor_json(loop.monitor());
  if (idle) summary["idle"] = monitor_json(*idle);
  if (udp)
    summary["udp"] = {{"answers", udp->round_trips().count()},
                      {"round_trip", timings_json(udp->round_trips())},
                      {"refused", udp->refused()},
                      {"missed", udp->missed()}};
  summary["resolved"] = resolved_json(simulation.method());
  const RealTimeGrants granted = loop.granted();
  summary["granted"] = {
      {"memory", granted.memory}, {"scheduling", granted.scheduling}, {"processor", granted.processor}};
  summary["worst_case"] = loop.worst_case();
  summary["warnings"] = simulation.warnings();
  return summary;
}

int live(const LiveArguments& arguments) {
  const LoadedModel loaded = load(arguments.model, arguments.settings, arguments.quiet, arguments.most_modes);
  InputTables played = input_tables(arguments.inputs, loaded.model->spec().inputs);
  RecordedInputs& inputs = played.tables;
  check_record(arguments, loaded, played.files);
  RunOptions options = run_options(arguments.method, loaded.model->spec().simulation);
  options.inputs = inputs.start();
  const std::unique_ptr<Simulation> simulation = [&] {
    const Busy busy("assembling the mechanism", !arguments.quiet);
    return std::make_unique<Simulation>(loaded.model, options);
  }();
  inputs.attach(*simulation);
  if (!arguments.quiet) print_advice(*simulation);

  const RealTimeOptions wanted = loop_options(arguments);
  const std::unique_ptr<RealTimeMonitor> idle =
      watch_idle_machine(arguments, simulation->step_size(), wanted);
  RealTimeLoop loop(*simulation, wanted);
  std::unique_ptr<RealTimeRecorder> recorder;
  if (!arguments.record.empty())
    recorder = std::make_unique<RealTimeRecorder>(arguments.record, *simulation, options_json(arguments),
                                                  simulation->method().output_interval);
  if (arguments.paused) loop.request({RealTimeRequest::Kind::pause});
  Ends ends(loop, inputs);
  loop.add(ends);
  const Exchanges exchanges = add_exchanges(arguments, *simulation, loop);
  const UdpExchange* udp = exchanges.udp.get();
  const std::string end = serve(arguments, *simulation, loop, recorder.get());
  Json summary = live_summary(*simulation, loop, end, idle.get(), udp);
  for (const std::string& warning : simulation->warnings()) print_warning(warning);
  if (recorder) {
    recorder->finish(loop, to_text(summary));
    summary["record"] = recorder->path();
  }
  if (arguments.json)
    print_data(to_text(summary) + '\n');
  else if (!arguments.quiet)
    print_data(monitor_table(loop, idle.get(), udp));
  const bool failed = loop.state() == RealTimeLoop::State::failed;
  if (failed) print_error(end);
  return failed ? Exit::failed : done;
}

void add_page_options(Parser& parser, LiveArguments& a) {
  parser.add_option("--port", a.port, "Port of the page; 0: a free one")
      .within(0, 65535)
      .type_name("N")
      .group("Page");
  parser
      .add_option("--address", a.address,
                  "Address that it is served at; other than the loopback interface's,\nothers can reach it, "
                  "and need the token")
      .type_name("A")
      .group("Page");
  parser
      .add_option("--token", a.token,
                  "Secret that viewers need; default: a new one if others can reach the page")
      .type_name("T")
      .group("Page");
  const Option open =
      parser.add_flag("--open", a.open, "Open the page in the browser, in any case").group("Page");
  parser.add_flag("--no-open", a.no_open, "Do not open it").excludes(open).group("Page");
  parser.add_flag("--paused", a.paused, "Begin with a pause").group("Page");
}

void add_loop_options(Parser& parser, LiveArguments& a) {
  add_clock_options(parser, a.clock);
  parser
      .add_option("--overrun", a.policy,
                  "When a step was not ready in time:\n"
                  "catch_up: the next ones begin at once\n"
                  "skip_output: the same, without pictures and rows\n"
                  "slow_down: the clock is set back\n"
                  "stop: it ends")
      .one_of(policies)
      .type_name("NAME")
      .group("Clock");
  parser.add_option("--spin", a.clock.spin, "Seconds of busy waiting before a step")
      .from(0, 0.1)
      .type_name("S")
      .group("Clock");
  parser.add_flag("--no-lock", a.no_lock, "Do not lock the memory").group("Clock");
  parser.add_option("--idle", a.idle, "Watch the idle machine for so many seconds first, to compare with")
      .above(0)
      .type_name("S")
      .group("Clock");
}

void add_exchange_options(Parser& parser, LiveArguments& a) {
  parser
      .add_option("--udp", a.udp, "Exchange signals with another program by UDP at this port; 0: a free one")
      .within(0, 65535)
      .type_name("PORT")
      .group("Exchange");
  parser.add_option("--udp-address", a.udp_address, "Address at which packets are taken")
      .type_name("A")
      .group("Exchange");
  parser
      .add_option(
          "--udp-wait", a.udp_wait,
          "Most seconds that a step waits for the answer to the last\noutputs; 0: it uses the latest answer")
      .from(0, 10)
      .type_name("S")
      .group("Exchange");
  parser
      .add_option("--shared-memory", a.shared_memory,
                  "Exchange signals with another program in shared memory of this name")
      .type_name("NAME")
      .group("Exchange");
  parser
      .add_option("--send", a.sent,
                  "Channel that is sent to the other program; may be repeated; default: the\nmodel's outputs")
      .repeated()
      .type_name("CHANNEL")
      .group("Exchange");
  parser.add_option("--take", a.taken, "Input that the other program sets; may be repeated; default: all")
      .repeated()
      .type_name("INPUT")
      .group("Exchange");
}

}  // namespace

Command add_live(CommandLine& program) {
  Parser parser = program.add_command("live", "Run a model against the clock, shown and driven in a browser");
  const auto a = std::make_shared<LiveArguments>();
  parser.add_option("model", a->model, "Model file (YAML)").required().type_name("MODEL");
  add_set_option(parser, a->settings);
  add_input_option(parser, a->inputs);
  parser
      .add_option("--duration", a->duration,
                  "Simulated seconds after which the run ends; default: until it is interrupted")
      .above(0)
      .type_name("S");
  parser.add_option("--record", a->record, "Results file (HDF5) of the run, with the times of its steps")
      .type_name("FILE.h5");
  add_page_options(parser, *a);
  add_loop_options(parser, *a);
  add_exchange_options(parser, *a);
  parser.add_flag("--json", a->json, "The summary as JSON, behind the line with the page's address");
  parser.add_flag("-q,--quiet", a->quiet, "No summary");
  add_method_options(parser, a->method);
  add_most_modes_option(parser, a->most_modes);
  parser.footer(
      "The address of the page is the first line on the standard output. The viewer that takes control "
      "pauses, "
      "resets, sets\nthe inputs; others look on. Control-C ends it.\n"
      "Example:\n  mimbre live examples/iltis/vehicle.yaml --open");
  return {parser, [a, parser] {
            if (parser.has("--token") && a->token.empty())
              throw UsageError("--token: the token is empty; leave the option out if viewers need none");
            return live(*a);
          }};
}

}  // namespace mimbre::app
