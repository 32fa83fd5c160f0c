#include "base/hdf5.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>

namespace mimbre::hdf5_test {
namespace {

/// A file with one dataset of four numbers, made as `creation` says; and the same file with other bytes.
class SmallFile {
 public:
  explicit SmallFile(const hdf5::Handle& creation)
      : path_(std::filesystem::temp_directory_path() / ("mimbre-hdf5-" + std::to_string(getpid()))) {
    const hsize_t count = 4;
    const std::array<double, 4> values{1, 2, 3, 4};
    const hdf5::Handle file(H5Fcreate(path_.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT));
    const hdf5::Handle space(H5Screate_simple(1, &count, nullptr));
    const hdf5::Handle data(H5Dcreate2(file.get(), "a", H5T_NATIVE_DOUBLE, space.get(), H5P_DEFAULT,
                                       creation.get(), H5P_DEFAULT));
    H5Dwrite(data.get(), H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
  }
  ~SmallFile() { std::filesystem::remove(path_); }
  SmallFile(const SmallFile&) = delete;
  SmallFile& operator=(const SmallFile&) = delete;

  bool opens() const {
    const hdf5::Quiet quiet;
    const hdf5::Handle file(H5Fopen(path_.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT));
    return hdf5::open_dataset(file.get(), "a").valid();
  }

  /// Writes numbers in place of these, or so many bytes before them.
  template <class Numbers, class Others>
  void replace(const Numbers& these, const Others& by, std::size_t before = 0) const {
    std::ifstream in(path_, std::ios::binary);
    std::string bytes{std::istreambuf_iterator<char>(in), {}};
    const auto at = bytes.find(std::string(reinterpret_cast<const char*>(these.data()), sizeof these));
    ASSERT_NE(at, std::string::npos);
    std::memcpy(&bytes[at - before], by.data(), sizeof by);
    std::ofstream(path_, std::ios::binary) << bytes;
  }

 private:
  std::filesystem::path path_;
};

/// A damaged header that announces more values than lie in it.
TEST(Hdf5, ReadsNoMoreThanACompactDatasetHas) {
  const hdf5::Handle creation(H5Pcreate(H5P_DATASET_CREATE));
  H5Pset_layout(creation.get(), H5D_COMPACT);
  const SmallFile file(creation);
  EXPECT_TRUE(file.opens());
  // Its size along the axis, and the largest that may be.
  file.replace(std::array<hsize_t, 2>{4, 4}, std::array<hsize_t, 2>{140, 140});
  EXPECT_FALSE(file.opens());
}

/// A damaged header that knows of no chunks.
TEST(Hdf5, ReadsNoChunksThatAreNotThere) {
  const hdf5::Handle creation(H5Pcreate(H5P_DATASET_CREATE));
  const hsize_t chunk = 3;
  H5Pset_chunk(creation.get(), 1, &chunk);
  const SmallFile file(creation);
  EXPECT_TRUE(file.opens());
  // Before the chunk's size and that of a number stands the address of their index.
  const std::array<std::uint32_t, 2> sizes{3, 8};
  file.replace(sizes, std::array<haddr_t, 1>{HADDR_UNDEF}, sizeof(haddr_t));
  EXPECT_FALSE(file.opens());
}

}  // namespace
}  // namespace mimbre::hdf5_test
