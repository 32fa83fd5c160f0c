#include "support/json.h"

#include <nlohmann/json.hpp>
#include <ostream>
#include <stdexcept>

namespace mimbre::test {
namespace {

const nlohmann::json& of(const std::shared_ptr<const void>& value) {
  if (!value) throw std::runtime_error("no JSON value");
  return *static_cast<const nlohmann::json*>(value.get());
}

}  // namespace

Json Json::parse(const std::string& text) {
  Json json;
  json.value_ = std::make_shared<const nlohmann::json>(nlohmann::json::parse(text));
  return json;
}

Json Json::at(const std::string& key) const {
  Json json;
  json.value_ = std::shared_ptr<const void>(value_, &of(value_).at(key));
  return json;
}

Json Json::at(std::size_t index) const {
  Json json;
  json.value_ = std::shared_ptr<const void>(value_, &of(value_).at(index));
  return json;
}

Json Json::child(std::size_t index) const {
  Json json;
  auto it = of(value_).begin();
  std::advance(it, static_cast<std::ptrdiff_t>(index));
  json.value_ = std::shared_ptr<const void>(value_, &*it);
  return json;
}

bool Json::contains(const std::string& key) const { return of(value_).contains(key); }

std::size_t Json::size() const {
  const nlohmann::json& value = of(value_);
  if (!value.is_structured()) throw std::runtime_error("neither an array nor an object: " + value.dump());
  return value.size();
}

bool Json::is_null() const { return of(value_).is_null(); }
bool Json::is_string() const { return of(value_).is_string(); }
bool Json::is_number() const { return of(value_).is_number(); }
bool Json::is_array() const { return of(value_).is_array(); }

std::vector<std::string> Json::keys() const {
  std::vector<std::string> names;
  for (const auto& [key, value] : of(value_).get_ref<const nlohmann::json::object_t&>()) names.push_back(key);
  return names;
}

std::string Json::dump() const { return of(value_).dump(); }

Json Json::without(const std::string& key) const {
  nlohmann::json value = of(value_);
  if (value.erase(key) != 1) throw std::runtime_error("no key " + key);
  Json json;
  json.value_ = std::make_shared<const nlohmann::json>(std::move(value));
  return json;
}

double Json::number() const {
  if (!of(value_).is_number()) throw std::runtime_error("not a number: " + dump());
  return of(value_).get<double>();
}

bool Json::boolean() const { return of(value_).get<bool>(); }
std::string Json::text() const { return of(value_).get<std::string>(); }

std::vector<double> Json::numbers() const {
  std::vector<double> all;
  for (const Json& entry : *this) all.push_back(entry.number());
  return all;
}

std::vector<std::string> Json::texts() const {
  std::vector<std::string> all;
  for (const Json& entry : *this) all.push_back(entry.text());
  return all;
}

bool Json::same(const Json& other) const { return of(value_) == of(other.value_); }

std::ostream& operator<<(std::ostream& out, const Json& json) { return out << json.dump(); }

}  // namespace mimbre::test
