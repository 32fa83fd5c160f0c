#include "fmu/plan.h"

#include <cstring>

namespace mimbre::fmu {
namespace {

/// Puts values behind each other, or takes them back: the same list serves both.
class PlanWriter {
 public:
  std::string bytes;
  void operator()(const std::string& text) {
    (*this)(static_cast<std::uint64_t>(text.size()));
    bytes += text;
  }
  template <class Item>
  void operator()(const std::vector<Item>& items) {
    (*this)(static_cast<std::uint64_t>(items.size()));
    for (const Item& item : items) put(item);
  }
  template <class Number>
  requires std::is_arithmetic_v<Number> || std::is_enum_v<Number>
  void operator()(Number number) { bytes.append(reinterpret_cast<const char*>(&number), sizeof number); }

 private:
  template <class Item>
  void put(const Item& item);
};

class PlanReader {
 public:
  explicit PlanReader(std::string_view bytes) : bytes_(bytes) {}
  bool good() const { return good_ && bytes_.empty(); }
  void operator()(std::string& text) {
    const std::uint64_t size = count();
    text = bytes_.substr(0, size);
    bytes_.remove_prefix(size);
  }
  template <class Item>
  void operator()(std::vector<Item>& items) {
    items.clear();
    for (std::uint64_t left = count(); left > 0 && good_; --left) take(items.emplace_back());
  }
  template <class Number>
  requires std::is_arithmetic_v<Number> || std::is_enum_v<Number>
  void operator()(Number& number) {
    good_ = good_ && bytes_.size() >= sizeof number;
    if (!good_) return;
    std::memcpy(&number, bytes_.data(), sizeof number);
    bytes_.remove_prefix(sizeof number);
  }

 private:
  template <class Item>
  void take(Item& item);
  /// Each thing that is counted has a byte at least.
  std::uint64_t count() {
    std::uint64_t value = 0;
    (*this)(value);
    good_ = good_ && value <= bytes_.size();
    return good_ ? value : 0;
  }
  std::string_view bytes_;
  bool good_ = true;
};

template <class S, class Each>
void of_slot(S& s, Each&& each) {
  each(s.name);
  each(s.reference);
  each(s.type);
  each(s.element);
  each(s.start);
}
template <class S, class Each>
void of_setting(S& s, Each&& each) {
  each(s.name);
  each(s.reference);
  each(s.type);
  each(s.values);
}
template <class P, class Each>
void of_plan(P& p, Each&& each) {
  each(p.version);
  for (auto* text : {&p.binary, &p.resources, &p.token, &p.identifier, &p.instance}) each(*text);
  each(p.saves);
  each(p.inputs_of_the_end);
  each(p.inputs);
  each(p.outputs);
  each(p.settings);
}

template <class Item>
void PlanWriter::put(const Item& item) {
  if constexpr (std::is_same_v<Item, Slot>)
    of_slot(item, *this);
  else if constexpr (std::is_same_v<Item, Setting>)
    of_setting(item, *this);
  else
    (*this)(item);
}
template <class Item>
void PlanReader::take(Item& item) {
  if constexpr (std::is_same_v<Item, Slot>)
    of_slot(item, *this);
  else if constexpr (std::is_same_v<Item, Setting>)
    of_setting(item, *this);
  else
    (*this)(item);
}

}  // namespace

std::string to_bytes(const Plan& plan) {
  PlanWriter writer;
  of_plan(plan, writer);
  return std::move(writer.bytes);
}

bool from_bytes(std::string_view bytes, Plan& plan) {
  PlanReader reader(bytes);
  of_plan(plan, reader);
  return reader.good();
}

}  // namespace mimbre::fmu
