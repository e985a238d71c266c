// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <set>
#include <tuple>
#include <vector>

#include "crease/collision/contact.hpp"

namespace crease {

/// What touches what.
using ContactKey = std::tuple<ContactType, int, FeatureKind, int, std::array<int, 3>>;

inline ContactKey key_of(const Contact& c) {
  return {c.type, c.obstacle, c.feature.kind, c.feature.index, c.vertices};
}

inline std::set<ContactKey> keys_of(const std::vector<Contact>& contacts) {
  std::set<ContactKey> keys;
  for (const Contact& contact : contacts) keys.insert(key_of(contact));
  return keys;
}

/// Adds the contacts of `more` that are not in `known`, to both; their number.
inline int add_new(std::vector<Contact>& contacts, std::set<ContactKey>& known, const std::vector<Contact>& more) {
  int n = 0;
  for (const Contact& contact : more) {
    if (!known.insert(key_of(contact)).second) continue;
    contacts.push_back(contact);
    ++n;
  }
  return n;
}

/// Adds what a solution runs into; the number. The same pair may do so again at another place, unless it was inside to
/// begin with: then it comes out no faster than it may, and stays inside for now.
inline int add_foreseen(std::vector<Contact>& contacts, std::set<ContactKey>& inside,
                        const std::vector<Contact>& foreseen) {
  int n = 0;
  for (const Contact& contact : foreseen) {
    if (contact.distance < 0 && !inside.insert(key_of(contact)).second) continue;
    contacts.push_back(contact);
    ++n;
  }
  return n;
}

}  // namespace crease
