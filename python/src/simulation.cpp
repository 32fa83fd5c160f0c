#include "mimbre/simulation.h"

#include <fmt/format.h>
#include <nanobind/eigen/dense.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/unique_ptr.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <exception>
#include <memory>
#include <optional>

#include "attention.h"
#include "bindings.h"
#include "clocked.h"
#include "loaded_model.h"
#include "picture.h"

namespace mimbre::python {
namespace {

/// Numbers of Python that stand for inputs or channels: those are taken from there before each step, these
/// are put there after it.
struct Live {
  std::vector<int> numbers;  ///< -1: another array has this input by now
  std::shared_ptr<std::vector<double>> values;
  std::vector<double> taken = {};  ///< of inputs, at the last step
  bool left = false;               ///< by Python, at the last step

  bool has_none() const {
    return std::all_of(numbers.begin(), numbers.end(), [](int number) { return number < 0; });
  }
};

void refuse_below_zero(const char* method, std::int64_t count) {
  if (count < 0)
    throw InputError(Mark{}, fmt::format("{}: count is {}; it cannot be below 0", method, count));
}

/// A Simulation for Python: one thread at a time, which others are told instead of crashing.
class Stepper {
 public:
  /// `inputs`: what inputs and tunable parameters start with, by name.
  Stepper(const LoadedModel& loaded, const MethodChoice& method, const std::map<std::string, double>& inputs)
      : simulation_([&] {
          const nb::gil_scoped_release others_run;
          RunOptions options = method.options(loaded.model->spec().simulation);
          options.inputs = inputs;
          return Simulation(loaded.model, options);
        }()) {}

  /// The simulation, for this thread alone as long as the turn lasts.
  class Turn {
   public:
    explicit Turn(Stepper& stepper) : stepper_(stepper) {
      if (stepper.taken_.exchange(true))
        throw Failure("another thread is stepping this simulation; clone() makes one of its own");
    }
    ~Turn() { stepper_.taken_ = false; }
    Turn(const Turn&) = delete;
    Turn& operator=(const Turn&) = delete;
    Simulation* operator->() const { return &stepper_.simulation_; }
    Simulation& operator*() const { return stepper_.simulation_; }

   private:
    Stepper& stepper_;
  };

  void step(std::int64_t count) {
    refuse_below_zero("step", count);
    go([&](Simulation& simulation, Attention& attention) {
      StepReport report;
      for (std::int64_t k = 0; k < count && report.ok(); ++k) {
        if (k > 0 && attention.stop()) break;
        report = one_step([&] { return simulation.step(); });
        if (simulation.stopped()) break;
      }
      return report;
    });
  }

  /// With the steps of a run to `time`: a rest that is no whole step is one, or, less than a thousandth of a
  /// step, goes to the last.
  void step_until(double time) {
    go([&](Simulation& simulation, Attention& attention) {
      StepReport report;
      const double rest = time - simulation.time(), step = simulation.step_size();
      if (!std::isfinite(time) || rest < 0)
        throw InputError(Mark{},
                         fmt::format("step_until: {} s is not after now, t = {} s", time, simulation.time()));
      if (rest == 0) return report;
      const double steps = std::max(1.0, std::ceil(rest / step - 1e-3));
      for (double k = 1; k <= steps && report.ok(); ++k) {
        if (k > 1 && attention.stop()) break;
        report = one_step([&] { return k < steps ? simulation.step() : simulation.step_to(time); });
        if (simulation.stopped()) break;
      }
      return report;
    });
  }

  /// Steps against the clock. `each_step` (None: nothing) is called after each; `at` with the page's address.
  std::string clocked(const ClockedOptions& options, const nb::object& each_step, const nb::object& at) {
    const Turn turn(*this);
    Attention attention;
    std::exception_ptr wrong;
    ClockedCalls calls;
    calls.before = [&] {
      try {
        if (!wrong) put_inputs();
      } catch (...) {
        wrong = std::current_exception();
      }
    };
    calls.after = [&] {
      if (each_step.is_none()) return;
      put_channels();
      attention.call([&] { each_step(); });
    };
    calls.stop = [&] { return wrong || attention.stop(); };
    calls.at = [&](const std::string& url) { attention.call([&] { at(url); }); };
    std::string told;
    {
      const nb::gil_scoped_release others_run;
      told = python::clocked(*turn, options, calls);
    }
    put_channels();
    attention.raise();
    if (wrong) std::rethrow_exception(wrong);
    return told;
  }

  /// The same as step(), without the interpreter's lock; what went wrong, nothing where it went well.
  std::string step_or_say(std::int64_t count) {
    const Turn turn(*this);
    StepReport report;
    for (std::int64_t k = 0; k < count && report.ok(); ++k) {
      report = one_step([&] { return turn->step(); });
      if (turn->stopped()) break;
    }
    put_channels();
    return report.ok() ? std::string() : turn->explain(report);
  }

  nb::bytes save() {
    const std::vector<std::byte> block = Turn(*this)->save().bytes();
    return nb::bytes(block.data(), block.size());
  }
  void restore(const nb::bytes& block) {
    const Turn turn(*this);
    turn->restore(
        Simulation::Snapshot::from_bytes({reinterpret_cast<const std::byte*>(block.c_str()), block.size()}));
    for (Live& live : inputs_) take_values(live);
    put_channels();
  }

  Picture lines() {
    const Turn turn(*this);
    if (!header_) header_ = turn->header("");
    return picture(*turn, *header_);
  }

  /// An array that inputs are taken from before each step, or that has channels' values after it.
  using Array = nb::ndarray<nb::numpy, double, nb::ndim<1>>;
  Array live_inputs(const std::vector<std::string>& names) {
    const Turn turn(*this);
    Live live{{}, std::make_shared<std::vector<double>>()};
    for (const std::string& name : names) live.numbers.push_back(turn->input(name));
    for (Live& before : inputs_)
      for (int& number : before.numbers)
        if (std::find(live.numbers.begin(), live.numbers.end(), number) != live.numbers.end()) number = -1;
    std::erase_if(inputs_, [](const Live& before) { return before.has_none(); });
    live.values->resize(names.size());
    take_values(live);
    return array(inputs_.emplace_back(std::move(live)));
  }
  Array live_channels(const std::vector<std::string>& names) {
    const Turn turn(*this);
    Live live{{}, std::make_shared<std::vector<double>>(names.size())};
    for (const std::string& name : names) live.numbers.push_back(turn->channel(name).index);
    channels_.push_back(live);
    put_channels();
    return array(live);
  }

 private:
  /// Steps without the interpreter's lock, then tells what went wrong.
  template <class Steps>
  void go(const Steps& steps) {
    const Turn turn(*this);
    Attention attention;
    StepReport report;
    {
      const nb::gil_scoped_release others_run;
      report = steps(*turn, attention);
    }
    put_channels();
    attention.raise();
    if (!report.ok()) throw Failure(turn->explain(report));
  }

  template <class Step>
  StepReport one_step(const Step& step) {
    put_inputs();
    return step();
  }

  /// What was written into an array that Python has left since counts, once: it may be all that was wanted.
  void put_inputs() {
    for (Live& live : inputs_) live.left = live.values.use_count() == 1;
    try {
      for (Live& live : inputs_) {
        if (live.left && *live.values == live.taken) continue;
        for (std::size_t k = 0; k < live.numbers.size(); ++k)
          if (live.numbers[k] >= 0) put_input(live.numbers[k], (*live.values)[k]);
        live.taken = *live.values;
      }
    } catch (...) {
      erase_left();
      throw;
    }
    erase_left();
  }
  void erase_left() {
    std::erase_if(inputs_, [](const Live& live) { return live.left; });
  }
  void put_input(int input, double value) {
    if (!std::isfinite(value))
      throw InputError(Mark{},
                       fmt::format("input '{}': is {}; a finite number is needed", name_of(input), value));
    simulation_.set_input(input, value);
  }

  std::string name_of(int input) const { return simulation_.inputs()[static_cast<std::size_t>(input)].name; }

  /// What the inputs are now, so that the next step leaves them so.
  void take_values(Live& inputs) const {
    for (std::size_t k = 0; k < inputs.numbers.size(); ++k)
      if (inputs.numbers[k] >= 0) (*inputs.values)[k] = simulation_.input_value(inputs.numbers[k]);
    inputs.taken = *inputs.values;
  }

  void put_channels() {
    std::erase_if(channels_, [](const Live& live) { return live.values.use_count() == 1; });
    for (const Live& live : channels_)
      for (std::size_t k = 0; k < live.numbers.size(); ++k)
        (*live.values)[k] = simulation_.value({live.numbers[k]});
  }

  /// The memory outlives the simulation where Python still looks at it.
  static Array array(const Live& live) {
    auto owner = std::make_unique<std::shared_ptr<std::vector<double>>>(live.values);
    const nb::capsule capsule(
        owner.get(), [](void* p) noexcept { delete static_cast<std::shared_ptr<std::vector<double>>*>(p); });
    owner.release();
    return Array(live.values->data(), {live.values->size()}, capsule);
  }

  Simulation simulation_;
  std::vector<Live> inputs_, channels_;
  std::optional<ResultsHeader> header_;  ///< where pictures were asked for
  std::atomic<bool> taken_{false};
};

using Turn = Stepper::Turn;

/// An input of one simulation, found once.
struct InputHandle {
  Stepper* stepper;
  int number;

  double get() const { return Turn(*stepper)->input_value(number); }
  void set(double value) const {
    const Turn turn(*stepper);
    if (!std::isfinite(value))
      throw InputError(Mark{},
                       fmt::format("input '{}': is {}; a finite number is needed", info(turn).name, value));
    turn->set_input(number, value);
  }
  spec::Input information() const { return info(Turn(*stepper)); }

 private:
  const spec::Input& info(const Turn& turn) const { return turn->inputs()[static_cast<std::size_t>(number)]; }
};

struct ChannelHandle {
  Stepper* stepper;
  int number;

  double get() const { return Turn(*stepper)->value({number}); }
  ChannelInfo information() const { return Turn(*stepper)->channels()[static_cast<std::size_t>(number)]; }
};

/// Steps one after another; what went wrong with each.
std::vector<std::string> step_all(const std::vector<Stepper*>& steppers, std::int64_t count) {
  for (const Stepper* stepper : steppers)
    if (!stepper) throw InputError(Mark{}, "step_all: simulations are needed, not None");
  refuse_below_zero("step_all", count);
  const nb::gil_scoped_release others_run;
  std::vector<std::string> failures;
  for (Stepper* stepper : steppers) failures.push_back(stepper->step_or_say(count));
  return failures;
}

std::map<std::string, double> energy_of(Stepper& stepper) {
  const Turn turn(stepper);
  std::map<std::string, double> terms;
  for (const EnergyTerm& term : energy_terms) terms[term.name] = turn->energy().*term.value;
  return terms;
}

/// Position, and rotation matrix by rows.
auto pose_of(Stepper& stepper, const std::string& body) {
  const Turn turn(stepper);
  const spec::Pose pose = turn->pose(turn->body(body));
  std::vector<double> position(pose.position.data(), pose.position.data() + 3), rotation;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column) rotation.push_back(pose.rotation(row, column));
  return std::tuple(position, rotation);
}

}  // namespace

void bind_simulation(nb::module_& module) {
  nb::class_<InputHandle>(module, "Input", "An input or a tunable parameter of a simulation.")
      .def_prop_rw("value", &InputHandle::get, &InputHandle::set,
                   "Its value; what is set is kept within its range and counts from the next step on.")
      .def_prop_ro(
          "name", [](const InputHandle& i) { return i.information().name; }, "Its name in the model.")
      .def_prop_ro(
          "unit", [](const InputHandle& i) { return i.information().unit; }, "The model's unit.")
      .def_prop_ro(
          "min", [](const InputHandle& i) { return i.information().min; }, "The least value.")
      .def_prop_ro(
          "max", [](const InputHandle& i) { return i.information().max; }, "The largest value.")
      .def_prop_ro(
          "tunable", [](const InputHandle& i) { return i.information().tunable; },
          "Whether it is a tunable parameter.");
  nb::class_<ChannelHandle>(module, "ChannelNow", "A channel of a simulation.")
      .def_prop_ro("value", &ChannelHandle::get, "Its value now.")
      .def_prop_ro(
          "name", [](const ChannelHandle& c) { return c.information().name; }, "Its name.")
      .def_prop_ro(
          "unit", [](const ChannelHandle& c) { return c.information().unit; }, "Its unit.")
      .def_prop_ro(
          "meaning", [](const ChannelHandle& c) { return c.information().meaning; }, "What it is.");
  nb::class_<Stepper>(module, "Simulation", "A compiled model in motion.")
      .def(nb::init<const LoadedModel&, const MethodChoice&, const std::map<std::string, double>&>(),
           nb::arg("model"), nb::arg("method"), nb::arg("inputs"))
      .def("step", &Stepper::step, nb::arg("count") = 1,
           "Makes a step, or `count` of them. Raises SimulationError where one fails: then the state is that "
           "before it. An event that stops the run ends it there (`stopped`); the next step makes the rest.")
      .def("step_until", &Stepper::step_until, nb::arg("time"),
           "Steps to that time (s), as a run does: the last step is shorter where it is no whole number.")
      .def(
          "clocked",
          [](Stepper& s, double duration, double speed, int overrun, bool lock, int priority, int processor,
             double spin, const nb::object& each_step, std::optional<int> port, const std::string& address,
             const std::string& token, const std::string& record, const nb::object& at) {
            ClockedOptions o;
            o.loop.duration = duration;
            o.loop.speed = speed;
            o.loop.overrun = static_cast<Overrun>(overrun);
            o.loop.lock_memory = lock;
            o.loop.priority = priority;
            o.loop.processor = processor;
            o.loop.spin = spin;
            o.port = port;
            o.address = address;
            o.token = token;
            o.record = record;
            return s.clocked(o, each_step, at);
          },
          nb::arg("duration"), nb::arg("speed"), nb::arg("overrun"), nb::arg("lock"), nb::arg("priority"),
          nb::arg("processor"), nb::arg("spin"), nb::arg("each_step").none(), nb::arg("port").none(),
          nb::arg("address"), nb::arg("token"), nb::arg("record"), nb::arg("at"),
          "Steps against the clock; what the monitor knows at the end, as JSON.")
      .def_prop_ro(
          "time", [](Stepper& s) { return Turn(s)->time(); }, "Where it has come to, s.")
      .def_prop_ro(
          "stopped", [](Stepper& s) { return Turn(s)->stopped(); },
          "Whether an event ended the last step and stops the run.")
      .def_prop_ro(
          "events",
          [](Stepper& s) {
            nb::dict events;
            for (const EventRecord& e : Turn(s)->events())
              events[nb::str(e.name.c_str())] = nb::make_tuple(e.count, e.first, e.last);
            return events;
          },
          "Of each event how often it happened, and when first and last (s; not a number: never).")
      .def_prop_ro(
          "step_size", [](Stepper& s) { return Turn(s)->step_size(); }, "The step, s.")
      .def_prop_ro(
          "coordinates", [](Stepper& s) { return Turn(s)->coordinates(); },
          "Number of velocity coordinates of the formulation.")
      .def_prop_ro("energy", &energy_of, "Terms of the energy balance so far, J.")
      .def_prop_ro(
          "warnings", [](Stepper& s) { return Turn(s)->warnings(); }, "What was suspicious so far.")
      .def_prop_ro(
          "fingerprint", [](Stepper& s) { return Turn(s)->fingerprint(); }, "Identifies model and method.")
      .def(
          "input",
          [](Stepper& s, const std::string& name) {
            return InputHandle{&s, Turn(s)->input(name)};
          },
          nb::arg("name"), nb::keep_alive<0, 1>(),
          "The input, or tunable parameter, of that name; UnknownName where there is none.")
      .def(
          "channel",
          [](Stepper& s, const std::string& name) {
            return ChannelHandle{&s, Turn(s)->channel(name).index};
          },
          nb::arg("name"), nb::keep_alive<0, 1>(),
          "The channel of that name; UnknownName where there is none.")
      .def("input_array", &Stepper::live_inputs, nb::arg("names"),
           "An array whose values these inputs have from the next step on, at each step, as long as it is "
           "kept. An input is in the array that was asked for last.")
      .def("channel_array", &Stepper::live_channels, nb::arg("names"),
           "An array that has these channels' values now, and after each step.")
      .def(
          "input_names",
          [](Stepper& s) {
            std::vector<std::string> names;
            for (const spec::Input& input : Turn(s)->inputs()) names.push_back(input.name);
            return names;
          },
          "Names of inputs and tunable parameters.")
      .def(
          "channel_names",
          [](Stepper& s) {
            std::vector<std::string> names;
            for (const ChannelInfo& channel : Turn(s)->channels()) names.push_back(channel.name);
            return names;
          },
          "Names of all channels.")
      .def("pose_parts", &pose_of, nb::arg("body"),
           "What `pose` gives, as lists of 3 and of 9 numbers, by rows.")
      .def(
          "lines", &Stepper::lines,
          "By body its name and the ends of the lines that draw it now, one pair after the other, global, m.")
      .def("save", &Stepper::save,
           "Everything that the next step depends on, for restore(), in another process too. What was "
           "written into an `input_array` since the last step is not in it.")
      .def("restore", &Stepper::restore, nb::arg("state"),
           "Goes back to a saved state, inputs and their arrays too; the same bits follow from there. "
           "InputError where it is of another model or method, or damaged.");
  module.def(
      "step_all", &step_all, nb::arg("simulations"), nb::arg("count"),
      "Makes so many steps with each of them, fewer where an event stops it, and leaves the interpreter to "
      "others meanwhile. What went wrong with each, empty where nothing did.");
}

}  // namespace mimbre::python
