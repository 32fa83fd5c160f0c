#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>

#include "live/exchanged.h"
#include "mimbre/diagnostics.h"
#include "mimbre/exchange_layout.h"

namespace mimbre {
namespace {

std::size_t aligned(std::size_t bytes) { return (bytes + 63) / 64 * 64; }

std::size_t block_bytes(std::size_t count) {
  return aligned(sizeof(mimbre_exchange_block) + sizeof(double) * count);
}

}  // namespace

struct SharedMemoryExchange::Impl {
  Impl(const Simulation& simulation, const std::string& given, const ExchangeOptions& options)
      : exchanged(simulation, options), name("/" + given) {
    if (given.empty() || given.size() > 200 || given.find('/') != std::string::npos)
      throw InputError(Mark{},
                       fmt::format("'{}' is no name of shared memory: 1 to 200 characters, no '/'", given));
    const std::string& names = exchanged.names();
    const std::size_t outputs_at = aligned(sizeof(mimbre_exchange_memory)),
                      inputs_at = outputs_at + block_bytes(exchanged.output_count()),
                      names_at = inputs_at + block_bytes(exchanged.input_count());
    size = names_at + aligned(names.size());
    const int file = shm_open(name.c_str(), O_RDWR | O_CREAT | O_EXCL, 0600);
    if (file < 0)
      throw std::runtime_error(
          errno == EEXIST
              ? fmt::format("there is shared memory '{}' already: another simulation's, or one's that was "
                            "killed (then remove /dev/shm{})",
                            given, name)
              : fmt::format("cannot make shared memory '{}': {}", given, std::strerror(errno)));
    void* at = MAP_FAILED;
    if (ftruncate(file, static_cast<off_t>(size)) == 0)
      at = mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
    const std::string why = std::strerror(errno);
    close(file);
    if (at == MAP_FAILED) {
      shm_unlink(name.c_str());
      throw std::runtime_error(fmt::format("cannot make shared memory '{}': {}", given, why));
    }
    char* const bytes = static_cast<char*>(at);
    memory = reinterpret_cast<mimbre_exchange_memory*>(bytes);
    outputs = reinterpret_cast<mimbre_exchange_block*>(bytes + outputs_at);
    inputs = reinterpret_cast<mimbre_exchange_block*>(bytes + inputs_at);
    std::memcpy(bytes + names_at, names.data(), names.size());
    const auto count = [](std::size_t number) { return static_cast<std::uint32_t>(number); };
    *memory = {0,
               count(size),
               exchanged.layout(),
               count(exchanged.output_count()),
               count(exchanged.input_count()),
               count(names_at),
               count(names.size()),
               count(outputs_at),
               count(inputs_at),
               1};
    values.resize(std::max(exchanged.output_count(), exchanged.input_count()));
    // Last: what has it is whole.
    __atomic_store_n(&memory->magic, MIMBRE_EXCHANGE_MAGIC, __ATOMIC_RELEASE);
  }
  ~Impl() {
    __atomic_store_n(&memory->alive, 0, __ATOMIC_RELEASE);
    munmap(memory, size);
    shm_unlink(name.c_str());
  }

  const live::Exchanged exchanged;
  const std::string name;
  std::size_t size = 0;
  mimbre_exchange_memory* memory = nullptr;
  mimbre_exchange_block *outputs = nullptr, *inputs = nullptr;
  std::vector<double> values;
  std::uint64_t steps = 0, seen = 0;
};

SharedMemoryExchange::SharedMemoryExchange(const Simulation& simulation, const std::string& name,
                                           const ExchangeOptions& options)
    : impl_(std::make_unique<Impl>(simulation, name, options)) {}
SharedMemoryExchange::~SharedMemoryExchange() = default;

void SharedMemoryExchange::before(Simulation& simulation) {
  Impl& s = *impl_;
  const std::uint64_t version = __atomic_load_n(&s.inputs->version, __ATOMIC_ACQUIRE);
  if (version == s.seen) return;
  std::uint64_t sequence = 0;
  double time = 0;
  // What is being written is taken with the next step.
  if (!mimbre_exchange_read(s.inputs, &sequence, &time, s.values.data(),
                            static_cast<std::uint32_t>(s.exchanged.input_count())))
    return;
  s.seen = version;
  s.exchanged.write(simulation, s.values.data());
}

void SharedMemoryExchange::after(Simulation& simulation, const StepReport& report, bool) {
  Impl& s = *impl_;
  if (!report.ok()) return;
  s.exchanged.read(simulation, s.values.data());
  mimbre_exchange_write(s.outputs, ++s.steps, simulation.time(), s.values.data(),
                        static_cast<std::uint32_t>(s.exchanged.output_count()));
  __atomic_store_n(&s.memory->alive, s.steps + 1, __ATOMIC_RELEASE);
}

}  // namespace mimbre
