#include "clocked.h"

#include <memory>

#include "bindings.h"
#include "json_text.h"
#include "mimbre/live_server.h"
#include "mimbre/real_time_summary.h"

namespace mimbre::python {
namespace {

class Calls : public RealTimePart {
 public:
  Calls(RealTimeLoop& loop, const ClockedCalls& calls) : loop_(loop), calls_(calls) {}
  void before(Simulation&) override { calls_.before(); }
  void after(Simulation&, const StepReport& report, bool) override {
    if (report.ok()) calls_.after();
  }
  void timed(const StepTiming&) override { look(); }
  void rests(Simulation&) override { look(); }

 private:
  void look() {
    if (calls_.stop()) loop_.stop();
  }
  RealTimeLoop& loop_;
  const ClockedCalls& calls_;
};

}  // namespace

std::string clocked(Simulation& simulation, const ClockedOptions& options, const ClockedCalls& calls) {
  RealTimeLoop loop(simulation, options.loop);
  std::unique_ptr<RealTimeRecorder> recorder;
  if (!options.record.empty())
    recorder = std::make_unique<RealTimeRecorder>(options.record, simulation, "{}",
                                                  simulation.method().output_interval);
  Calls part(loop, calls);
  loop.add(part);
  std::string end;
  {
    std::unique_ptr<LiveServer> server;
    if (options.port) {
      server = std::make_unique<LiveServer>(
          simulation, loop, LiveServerOptions{options.address, *options.port, options.token, recorder.get()});
      calls.at(server->url());
    }
    if (recorder) loop.add(*recorder);
    end = loop.run();
  }
  Json json = Json::parse(real_time_summary(loop.monitor()));
  json["message"] = end;
  const RealTimeGrants granted = loop.granted();
  json["granted"] = {
      {"memory", granted.memory}, {"scheduling", granted.scheduling}, {"processor", granted.processor}};
  json["worst_case"] = loop.worst_case();
  const std::string text = json_text(json);
  if (recorder) recorder->finish(loop, text);
  if (loop.state() == RealTimeLoop::State::failed) throw Failure(end);
  return text;
}

}  // namespace mimbre::python
