#pragma once
#include <vector>

#include "dynamics/relative/workspace.h"
#include "mimbre/channels.h"
#include "outputs/view.h"

namespace mimbre {

/// Of all pairs of a contact of the spec, the force on their spheres (of two spheres on the second); or with
/// `body`, of the tree, of those that press on it, the force on it. After the forces.
ContactSum contact_sum(const Compiled& model, const relative::Workspace<double>& work, int contact,
                       int body = -1);

/// The standard channels of a contact.
void add_contact_info(const spec::Contact& contact, std::vector<ChannelInfo>& info);
void read_contact(const ContactSum& sum, double* to);

}  // namespace mimbre
