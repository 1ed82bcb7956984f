// SPDX-License-Identifier: GPL-3.0-or-later
// Handle: an identifier of the HDF5 library. Included only by the sources that read and write maps.
#pragma once

#include <hdf5.h>

#include <stdexcept>
#include <vector>

namespace graze::apps::hdf5 {

/// An identifier of the HDF5 library, closed on destruction.
class Handle {
 public:
  using Close = herr_t (*)(hid_t);
  Handle(hid_t id, Close close) : id_(id), close_(close) {
    if (id < 0) throw std::runtime_error("the HDF5 library refuses");
  }
  ~Handle() {
    if (id_ >= 0) close_(id_);
  }
  Handle(Handle&& other) noexcept : id_(other.id_), close_(other.close_) { other.id_ = -1; }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  operator hid_t() const { return id_; }  // NOLINT(google-explicit-constructor): it stands for the number

 private:
  hid_t id_;
  Close close_;
};

/// @throws std::runtime_error if the library has failed.
inline void check(herr_t result) {
  if (result < 0) throw std::runtime_error("the HDF5 library refuses");
}

/// Switches off the library's own error messages: graze reports errors itself.
inline void silence() { H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr); }

inline Handle space_of(const std::vector<hsize_t>& size) {
  return {size.empty() ? H5Screate(H5S_SCALAR) : H5Screate_simple(static_cast<int>(size.size()), size.data(), nullptr), H5Sclose};
}

}  // namespace graze::apps::hdf5
