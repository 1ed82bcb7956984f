// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/console/output_file.hpp>
#include <graze/apps/map/map_file.hpp>
#include <graze/apps/map/map_store.hpp>
#include <graze/apps/results/input_file.hpp>
#include <graze/apps/results/run_identity.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <stdexcept>

namespace graze::apps {

namespace {

namespace fs = std::filesystem;

constexpr const char* run_file = "/run.json";

/// Identifies a run by everything on which a point's numbers depend.
std::uint64_t fingerprint_of(const Json& head) { return checksum(flat(identity_of(head, map_identity_parts))); }

/// Whether a file is the map that a run with this head would produce.
bool is_map_of(const std::string& file, const Json& head) {
  try {
    return !difference(MapFile(file).head(), head, map_identity_parts);
  } catch (const std::exception&) {  // not a map
    return false;
  }
}

}  // namespace

MapStore::MapStore(const MapPlan& plan, const Json& head, const std::string& advice)
    : plan_(plan), fingerprint_(fingerprint_of(head)), advice_(advice), kept_(static_cast<std::size_t>(plan.chunks())),
      finished_(static_cast<std::size_t>(plan.chunks()), false) {}

MapStore::MapStore(const MapPlan& plan, const Json& head, const std::string& folder, MapBeginning beginning)
    : plan_(plan), fingerprint_(fingerprint_of(head)), out_(folder), folder_(folder + "/chunks") {
  beginning == MapBeginning::resuming ? take_up(head) : begin(head, beginning == MapBeginning::overwriting);
}

void MapStore::lock() {
  lock_.emplace(folder_ + "/lock", fmt::format("{}: another graze map is at work there; wait for it, or end it", folder_));
}

void MapStore::begin(const Json& head, bool overwriting) {
  make_folder(folder_);
  lock();
  if (fs::exists(folder_ + run_file))
    throw std::invalid_argument(fmt::format(
        "--out: {0} holds an unfinished map; --resume {1} goes on with it, and without the folder {0} a new one begins", folder_,
        out_));
  if (!overwriting && fs::exists(out_ + "/map.h5") && !is_map_of(out_ + "/map.h5", head)) {
    remove();
    throw std::invalid_argument(
        fmt::format("--out {0}: another map is there, {0}/map.h5; give another folder, or --overwrite to replace it", out_));
  }
  finished_.assign(static_cast<std::size_t>(plan_.chunks()), false);
  Json run = head;
  run["chunk_rows"] = plan_.chunk_rows;
  if (const auto failure = write_whole(folder_ + run_file, pretty(run))) throw std::invalid_argument(*failure);
  if (const auto failure = sync_folder(folder_)) throw std::invalid_argument(*failure);
}

void MapStore::take_up(const Json& head) {
  const std::string name = folder_ + run_file;
  if (!fs::exists(name))
    throw std::invalid_argument(
        fmt::format("--resume: {}: no such file; give the folder that an interrupted run of graze map wrote with --out", name));
  lock();
  const auto refuse = [&name](const std::string& why) { return std::invalid_argument(fmt::format("--resume: {}{}", name, why)); };
  const std::string text = read_whole(name);
  Json run;
  try {
    run = parse_json(text);
    plan_.chunk_rows = run.at("chunk_rows");
  } catch (const Json::exception&) {
    throw refuse(" is damaged; compute the map anew");
  } catch (const std::invalid_argument& broken) {
    throw refuse(fmt::format(": {}; compute the map anew", broken.what()));
  }
  if (const auto found = difference(run, head, {"schema"})) throw refuse(fmt::format(" is of another kind: {}", *found));
  if (const auto found = difference(run, head, map_identity_parts))
    throw refuse(fmt::format(" is of another run: {}; give the same", *found));
  if (plan_.chunk_rows < 1) throw refuse(" is damaged; compute the map anew");
  finished_.assign(static_cast<std::size_t>(plan_.chunks()), false);
  // Remove files that were incomplete when the run ended.
  for (const auto& [folder, beginning] : {std::pair{folder_, "."}, {out_, ".map.h5."}})
    for (const fs::directory_entry& entry : fs::directory_iterator(folder))
      if (entry.path().filename().string().starts_with(beginning)) fs::remove(entry.path());
  for (int number = 0; number < plan_.chunks(); ++number) {
    if (!fs::exists(file(number))) continue;
    const bool sound = chunk_from(read_whole(file(number)), plan_, fingerprint_, number).has_value();
    finished_[static_cast<std::size_t>(number)] = sound;
    damaged_ += sound ? 0 : 1;
  }
}

std::string MapStore::file(int number) const { return fmt::format("{}/{:06}.chunk", folder_, number); }

std::vector<int> MapStore::missing() const {
  std::vector<int> numbers;
  for (int number = 0; number < plan_.chunks(); ++number)
    if (!has(number)) numbers.push_back(number);
  return numbers;
}

int MapStore::finished() const { return static_cast<int>(std::count(finished_.begin(), finished_.end(), true)); }

std::string MapStore::advice() const { return out_.empty() ? advice_ : fmt::format("--resume {} goes on with them", out_); }

std::optional<std::string> MapStore::keep(int number, const std::string& bytes) {
  if (folder_.empty()) {
    kept_.at(static_cast<std::size_t>(number)) = bytes;
  } else {
    if (auto failure = write_whole(file(number), bytes)) return failure;
    if (auto failure = sync_folder(folder_)) return failure;
  }
  finished_.at(static_cast<std::size_t>(number)) = true;
  return std::nullopt;
}

MapChunk MapStore::chunk(int number) const {
  const std::string bytes = folder_.empty() ? kept_.at(static_cast<std::size_t>(number)) : read_whole(file(number));
  auto chunk = chunk_from(bytes, plan_, fingerprint_, number);
  if (!chunk) throw std::runtime_error(file(number) + ": has been damaged meanwhile; --resume computes it again");
  return std::move(*chunk);
}

void MapStore::remove() {
  if (folder_.empty()) return;
  std::error_code error;  // a remaining file does no harm: the result takes precedence
  fs::remove_all(folder_, error);
}

}  // namespace graze::apps
