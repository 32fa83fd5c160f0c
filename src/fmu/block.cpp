#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <set>

#include "base/hash64.h"
#include "fmu/calls.h"
#include "fmu/package.h"
#include "fmu/remote.h"
#include "mimbre/diagnostics.h"
#include "mimbre/fmu_import.h"

namespace mimbre {
namespace {

using namespace fmu;

/// Those that a process may have but one instance of, by their digests: which have one now.
struct OnlyOnes {
  std::mutex guard;
  std::set<std::string> taken;
};
OnlyOnes& only_ones() {
  static OnlyOnes all;
  return all;
}

/// The right to have the instance of such an FMU; of others it is nothing.
class Claim {
 public:
  Claim(const std::string& digest, bool only_one) : digest_(only_one ? digest : std::string()) {
    if (digest_.empty()) return;
    const std::lock_guard guard(only_ones().guard);
    granted_ = only_ones().taken.insert(digest_).second;
  }
  ~Claim() {
    if (digest_.empty() || !granted_) return;
    const std::lock_guard guard(only_ones().guard);
    only_ones().taken.erase(digest_);
  }
  Claim(const Claim&) = delete;
  Claim& operator=(const Claim&) = delete;
  bool granted() const { return granted_; }

 private:
  std::string digest_;
  bool granted_ = true;
};

/// In this process.
class LocalInstance : public OutsideInstance {
 public:
  LocalInstance(std::shared_ptr<const Package> package, Plan plan, std::unique_ptr<Claim> claim)
      : package_(std::move(package)), claim_(std::move(claim)), calls_(std::move(plan)) {}

  bool open() { return calls_.open(); }
  bool exchange(const Instant& i) override {
    return calls_.exchange(i.time, i.interval, i.intervals, i.before, i.in, i.out);
  }
  bool save(std::vector<std::byte>& state) override { return calls_.save(state); }
  bool restore(std::span<const std::byte> state) override { return calls_.restore(state); }
  std::string message() const override { return calls_.message(); }
  std::string warning() const override { return calls_.warning(); }

 private:
  std::shared_ptr<const Package> package_;
  std::unique_ptr<Claim> claim_;
  Calls calls_;
};

class FmuBlock : public OutsideBlock {
 public:
  FmuBlock(FmuSettings settings, std::shared_ptr<const Package> package, Plan plan)
      : settings_(std::move(settings)), package_(std::move(package)), plan_(std::move(plan)) {}

  std::string label() const override {
    return fmt::format("FMU '{}'", std::filesystem::path(settings_.file).filename().string());
  }
  int inputs() const override { return static_cast<int>(plan_.inputs.size()); }
  int outputs() const override { return static_cast<int>(plan_.outputs.size()); }
  std::uint64_t identity() const override {
    Hash64 hash;
    hash.add(package_->digest());
    hash.add(to_bytes(plan_));
    return hash.value();
  }
  std::string not_saved() const override {
    return plan_.saves
               ? std::string()
               : "the FMU does not offer it (canGetAndSetFMUState and canSerializeFMUState are not both "
                 "true in its description)";
  }

  std::unique_ptr<OutsideInstance> instantiate(const std::string& name) const override {
    const auto refuse = [&](const std::string& why) {
      const bool tool = package_->description().needs_tool;
      throw InputError({settings_.file, 0, 0},
                       why + (tool ? " (it needs the program that made it: needsExecutionTool)" : ""));
    };
    Plan plan = plan_;
    const Package::Unpacked& unpacked = package_->unpacked();
    plan.binary = unpacked.binary;
    plan.resources = unpacked.resources;
    plan.instance = name;
    if (settings_.process) {
      auto remote = std::make_unique<RemoteInstance>(package_, settings_.timeout, inputs(), outputs());
      if (!remote->open(plan)) refuse(remote->message());
      return remote;
    }
    auto claim = std::make_unique<Claim>(package_->digest(), package_->description().once_per_process);
    if (!claim->granted())
      refuse(
          "can have but one instance in a process (canBeInstantiatedOnlyOncePerProcess), and has one "
          "already; "
          "give its signal `process: true`");
    auto local = std::make_unique<LocalInstance>(package_, std::move(plan), std::move(claim));
    if (!local->open()) refuse(local->message());
    return local;
  }

 private:
  FmuSettings settings_;
  std::shared_ptr<const Package> package_;
  Plan plan_;
};

/// Takes from a description what a model asks for.
class PlanMaker {
 public:
  PlanMaker(const FmuSettings& settings, const Description& description) : s_(settings), d_(description) {}

  Plan make() {
    Plan plan;
    plan.version = d_.version;
    plan.token = d_.token;
    plan.identifier = d_.identifier;
    plan.saves = d_.saves_state;
    plan.inputs_of_the_end = s_.inputs_of_the_end;
    if (s_.outputs.empty()) refuse("no outputs are taken from it");
    if (std::max(s_.inputs.size(), s_.outputs.size()) > most_outside_values)
      refuse(fmt::format("has {} inputs and {} outputs; up to {} of each are possible", s_.inputs.size(),
                         s_.outputs.size(), most_outside_values));
    for (const std::string& name : s_.inputs) plan.inputs.push_back(slot(name, "input"));
    for (const std::string& name : s_.outputs) plan.outputs.push_back(slot(name, "output"));
    for (const auto& [name, value] : s_.parameters) plan.settings.push_back(setting(name, value));
    return plan;
  }

 private:
  [[noreturn]] void refuse(const std::string& why) const { throw InputError({s_.file, 0, 0}, why); }

  const Variable& variable(const std::string& name, const std::string& causality) const {
    if (const Variable* found = d_.find(name)) return *found;
    std::vector<std::string> names = d_.names(causality);
    std::string known;
    for (std::size_t k = 0; k < std::min<std::size_t>(names.size(), 12); ++k)
      known += fmt::format("{}'{}'", k > 0 ? ", " : "", names[k]);
    if (names.size() > 12) known += ", …";
    refuse(fmt::format("has no variable '{}'{}; {}", name, did_you_mean(name, names),
                       names.empty() ? fmt::format("it has no {}s", causality)
                                     : fmt::format("its {}s are {}", causality, known)));
  }

  /// "x[2,3]": the variable and the place in it; a variable of that whole name comes first.
  Slot slot(const std::string& name, const std::string& causality) const {
    std::string base = name;
    std::vector<std::uint64_t> indices;
    if (!d_.find(name) && !name.empty() && name.back() == ']' && name.find('[') != std::string::npos) {
      base = name.substr(0, name.rfind('['));
      indices = indices_of(name.substr(base.size() + 1, name.size() - base.size() - 2), name);
    }
    const Variable& v = variable(base, causality);
    if (v.causality != causality &&
        !(causality == "output" && (v.causality == "local" || v.causality == "parameter")))
      refuse(fmt::format("variable '{}' is no {}: its causality is {}", base, causality, v.causality));
    if (v.type == Type::string || v.type == Type::other)
      refuse(fmt::format("variable '{}' is of type {}; signals are numbers", base, v.type_name));
    Slot slot;
    slot.name = v.name;
    slot.reference = v.reference;
    slot.type = v.type;
    if (indices.size() != v.dimensions.size())
      refuse(fmt::format("variable '{}' has {} dimensions: name one of its elements, such as '{}[{}]'", base,
                         v.dimensions.size(), base, v.dimensions.size() == 2 ? "1,1" : "1"));
    for (std::size_t k = 0; k < indices.size(); ++k) {
      if (indices[k] < 1 || indices[k] > v.dimensions[k])
        refuse(fmt::format("'{}' is beyond its array, whose size is {} there; elements count from 1", name,
                           v.dimensions[k]));
      slot.element = slot.element * v.dimensions[k] + indices[k] - 1;
    }
    slot.start.assign(v.size(), 0.0);
    if (v.start && v.type != Type::boolean)
      for (std::size_t k = 0; k < slot.start.size(); ++k)
        slot.start[k] = std::strtod((*v.start)[std::min(k, v.start->size() - 1)].c_str(), nullptr);
    return slot;
  }

  std::vector<std::uint64_t> indices_of(const std::string& text, const std::string& name) const {
    std::vector<std::uint64_t> indices;
    std::uint64_t number = 0;
    bool any = false;
    for (const char c : text + ",") {
      if (c == ',' && any) {
        indices.push_back(number);
        number = 0;
        any = false;
      } else if (c >= '0' && c <= '9' && number < 1000000000) {
        number = 10 * number + static_cast<std::uint64_t>(c - '0');
        any = true;
      } else {
        refuse(fmt::format("'{}' names no element; elements are such as 'x[1]' and 'x[2,3]'", name));
      }
    }
    return indices;
  }

  Setting setting(const std::string& name, const std::string& value) const {
    const Variable& v = variable(name, "parameter");
    if (v.variability == "constant" || v.causality == "independent" || v.causality == "calculatedParameter" ||
        v.causality == "structuralParameter" || !v.start)
      refuse(fmt::format("variable '{}' has no start value that could be set", name));
    if (v.type == Type::other) refuse(fmt::format("variable '{}' is of type {}", name, v.type_name));
    Setting setting{v.name, v.reference, v.type, {}};
    setting.values.assign(v.size(), value);
    for (std::string& text : setting.values) {
      if (v.type == Type::string) continue;
      if (v.type == Type::boolean && (text == "true" || text == "false")) {
        text = text == "true" ? "1" : "0";
        continue;
      }
      char* end = nullptr;
      const double number = std::strtod(text.c_str(), &end);
      if (text.empty() || *end != '\0' || !std::isfinite(number))
        refuse(fmt::format("variable '{}' is of type {}, and '{}' is none", name, v.type_name, text));
      const bool real = v.type == Type::float64 || v.type == Type::float32;
      if (!real && number != std::round(number))
        refuse(
            fmt::format("variable '{}' is of type {}, and {} is no whole number", name, v.type_name, text));
    }
    return setting;
  }

  const FmuSettings& s_;
  const Description& d_;
};

}  // namespace

std::shared_ptr<const OutsideBlock> load_fmu(const FmuSettings& settings) {
  if (!(settings.timeout > 0) || !std::isfinite(settings.timeout))
    throw InputError({settings.file, 0, 0},
                     fmt::format("its timeout is {} s; it is a time > 0", settings.timeout));
  std::shared_ptr<const Package> package = Package::open(settings.file);
  Plan plan = PlanMaker(settings, package->description()).make();
  return std::make_shared<const FmuBlock>(settings, std::move(package), std::move(plan));
}

}  // namespace mimbre
