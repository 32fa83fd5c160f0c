#include "fmu/fmu_files.h"

#include <fmt/format.h>
#include <zlib.h>

#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>

namespace mimbre::test {
namespace {

std::string low_bytes(std::size_t value, int bytes) {
  std::string text;
  for (int k = 0; k < bytes; ++k) text += static_cast<char>(value >> (8 * k) & 0xff);
  return text;
}

std::string unit_source() {
  std::ifstream file(std::string(MIMBRE_SOURCE_DIR) + "/tests/data/fmu/unit.c");
  return {(std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>()};
}

}  // namespace

std::string zip_of(const Members& members) {
  std::string bytes, directory;
  for (const auto& [name, data] : members) {
    const auto sum = crc32_z(0, reinterpret_cast<const Bytef*>(data.data()), data.size());
    const std::string sizes = low_bytes(sum, 4) + low_bytes(data.size(), 4) + low_bytes(data.size(), 4) +
                              low_bytes(name.size(), 2) + low_bytes(0, 2);
    directory += "PK\x01\x02" + low_bytes(20, 2) + low_bytes(20, 2) + low_bytes(0, 8) + sizes +
                 low_bytes(0, 10) + low_bytes(bytes.size(), 4) + name;
    bytes += "PK\x03\x04" + low_bytes(20, 2) + low_bytes(0, 8) + sizes + name + data;
  }
  return bytes + directory + "PK\x05\x06" + low_bytes(0, 4) + low_bytes(members.size(), 2) +
         low_bytes(members.size(), 2) + low_bytes(directory.size(), 4) + low_bytes(bytes.size(), 4) +
         low_bytes(0, 2);
}

std::string unit_description(int version, const std::string& attributes) {
  const std::string saves = version == 2 ? "canGetAndSetFMUstate=\"true\" canSerializeFMUstate=\"true\""
                                         : "canGetAndSetFMUState=\"true\" canSerializeFMUState=\"true\"";
  const std::string of = attributes.empty() ? saves : attributes;
  const auto variable = [&](const char* name, int reference, const char* more, const char* start,
                            const char* type) {
    const std::string value = *start ? fmt::format(" start=\"{}\"", start) : "";
    if (version == 3)
      return fmt::format("<{} name=\"{}\" valueReference=\"{}\" {}{}/>\n",
                         std::string(type) == "Real" ? "Float64" : "Int32", name, reference, more, value);
    return fmt::format("<ScalarVariable name=\"{}\" valueReference=\"{}\" {}><{}{}/></ScalarVariable>\n",
                       name, reference, more, type, value);
  };
  std::string text =
      version == 2 ? "<?xml version=\"1.0\"?>\n<fmiModelDescription fmiVersion=\"2.0\" modelName=\"unit\" "
                     "guid=\"{unit}\">\n<CoSimulation modelIdentifier=\"unit\" " +
                         of + "><SourceFiles><File name=\"unit.c\"/></SourceFiles></CoSimulation>\n"
                   : "<?xml version=\"1.0\"?>\n<fmiModelDescription fmiVersion=\"3.0\" modelName=\"unit\" "
                     "instantiationToken=\"{unit}\">\n<CoSimulation modelIdentifier=\"unit\" " +
                         of + "/>\n";
  text += "<ModelVariables>\n" + variable("y", 0, "causality=\"input\"", "0", "Real") +
          variable("r", 1, "causality=\"input\"", "0", "Real") +
          variable("u", 2, "causality=\"output\"", "", "Real") +
          variable("kp", 3, "causality=\"parameter\" variability=\"tunable\"", "1", "Real") +
          variable("ki", 4, "causality=\"parameter\" variability=\"tunable\"", "0", "Real") +
          variable("kind", 5, "causality=\"parameter\" variability=\"fixed\"", "0", "Integer") +
          "</ModelVariables>\n";
  text += version == 2 ? "<ModelStructure><Outputs><Unknown index=\"3\"/></Outputs></ModelStructure>\n"
                       : "<ModelStructure><Output valueReference=\"2\"/></ModelStructure>\n";
  return text + "</fmiModelDescription>\n";
}

Members unit_members(int version, const std::string& lines, const std::string& attributes) {
  Members members{
      {"modelDescription.xml", unit_description(version, attributes)},
      {"sources/unit.c", fmt::format("#define FMI_VERSION {}\n{}", version, lines) + unit_source()}};
  if (version == 3)
    members.emplace_back(
        "sources/buildDescription.xml",
        "<?xml version=\"1.0\"?>\n<fmiBuildDescription fmiVersion=\"3.0\"><BuildConfiguration "
        "modelIdentifier=\"unit\"><SourceFileSet language=\"C99\"><SourceFile "
        "name=\"unit.c\"/></SourceFileSet></BuildConfiguration></fmiBuildDescription>\n");
  return members;
}

FmuFolder::FmuFolder() {
  std::string name = (std::filesystem::temp_directory_path() / "mimbre-fmu-test-XXXXXX").string();
  path_ = mkdtemp(name.data()) ? name : std::string(".");
}

FmuFolder::~FmuFolder() {
  std::error_code ignored;
  if (path_ != ".") std::filesystem::remove_all(path_, ignored);
}

std::string FmuFolder::write(const std::string& name, const std::string& bytes) const {
  const std::string path = path_ + "/" + name;
  std::ofstream(path, std::ios::binary) << bytes;
  return path;
}

std::string FmuFolder::unit(int version, const std::string& lines, const std::string& attributes) const {
  return write("unit.fmu", zip_of(unit_members(version, lines, attributes)));
}

}  // namespace mimbre::test
