#include <fmt/format.h>
#include <zlib.h>

#include <array>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string_view>

#include "live/live_page.h"
#include "live/messages.h"
#include "live/page_solver.h"
#include "mimbre/model_bytes.h"
#include "mimbre/page.h"
#include "results/base64.h"
#include "results/report_page.h"

namespace mimbre {
namespace {

constexpr std::string_view data_mark = "%MIMBRE_DATA%";

/// As a gzip file.
std::vector<unsigned char> compressed(const void* from, std::size_t size) {
  constexpr int gzip = 16 + MAX_WBITS;
  z_stream stream{};
  if (deflateInit2(&stream, Z_BEST_COMPRESSION, Z_DEFLATED, gzip, 9, Z_DEFAULT_STRATEGY) != Z_OK)
    throw std::runtime_error("zlib cannot compress");
  std::vector<unsigned char> out(deflateBound(&stream, static_cast<uLong>(size)));
  stream.next_in = const_cast<Bytef*>(static_cast<const Bytef*>(from));
  stream.avail_in = static_cast<uInt>(size);
  stream.next_out = out.data();
  stream.avail_out = static_cast<uInt>(out.size());
  const int done = deflate(&stream, Z_FINISH);
  deflateEnd(&stream);
  if (done != Z_STREAM_END) throw std::runtime_error("zlib cannot compress");
  out.resize(stream.total_out);
  return out;
}

std::string packed(const void* from, std::size_t size) { return results::base64(compressed(from, size)); }

/// In a script element nothing may end it.
std::string without_tags(const std::string& json) {
  std::string safe;
  for (const char c : json) {
    if (c == '<')
      safe += "\\u003c";
    else
      safe += c;
  }
  return safe;
}

/// As the page has it: base64 of gzip.
std::string solver_of(const std::string& path) {
  if (path.empty()) {
    if (!has_page_solver())
      throw std::runtime_error(
          "this mimbre was built without the solver for pages; `make page` in its sources builds it (it "
          "needs "
          "emscripten)");
    return std::string(live::page_solver());
  }
  std::ifstream file(path, std::ios::binary);
  if (!file) throw std::runtime_error(fmt::format("cannot read '{}'", path));
  const std::string bytes{std::istreambuf_iterator<char>(file), {}};
  if (bytes.substr(0, 4) != std::string("\0asm", 4))
    throw std::runtime_error(fmt::format("'{}' is not WebAssembly; `make page` builds the solver", path));
  return packed(bytes.data(), bytes.size());
}

}  // namespace

bool has_page_solver() { return !live::page_solver().empty(); }

std::string page_html(const std::shared_ptr<const Model>& model, const std::string& wasm) {
  const std::string_view page = live::model_page();
  if (page.empty())
    throw std::runtime_error(
        "this mimbre was built without its pages; install Node.js 18 or newer with npm and configure with "
        "-DMIMBRE_WITH_REPORT=ON");
  const std::string solver = solver_of(wasm);
  const std::vector<std::byte> bytes = model_bytes(model->spec());
  Simulation simulation(model);
  RealTimeOptions options;
  options.overrun = Overrun::slow_down;
  const RealTimeLoop loop(simulation, options);
  const std::string data = fmt::format(R"({{"scene":{},"wasm":"{}","model":"{}"}})",
                                       without_tags(live::scene_text(simulation, loop, nullptr)), solver,
                                       packed(bytes.data(), bytes.size()));
  const std::size_t at = page.find(data_mark);
  std::string html(page.substr(0, at));
  html += data;
  html += page.substr(at + data_mark.size());
  return html;
}

void write_page(const std::shared_ptr<const Model>& model, const std::string& path, const std::string& wasm) {
  results::write_page(page_html(model, wasm), path);
}

}  // namespace mimbre
