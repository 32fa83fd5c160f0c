#include "clocked.h"

#include <memory>
#include <nlohmann/json.hpp>

#include "app/common.h"
#include "app/json.h"
#include "app/terminal/monitor.h"
#include "mimbre/live_server.h"

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
  app::Json json = app::monitor_json(loop.monitor());
  json["message"] = end;
  const RealTimeGrants granted = loop.granted();
  json["granted"] = {
      {"memory", granted.memory}, {"scheduling", granted.scheduling}, {"processor", granted.processor}};
  json["worst_case"] = loop.worst_case();
  if (recorder) recorder->finish(loop, app::to_text(json));
  if (loop.state() == RealTimeLoop::State::failed) throw app::Failure(end);
  return app::to_text(json);
}

}  // namespace mimbre::python
