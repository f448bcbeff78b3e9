/* SPDX-License-Identifier: MIT
 *
 * Tables -> what couples points, as codegen names it: for programs that read tables at run time
 */
#include "haptable_points.h"

void haptable_points_model_make(const struct haptable_pair_model* pair, struct haptable_points_model* points) {
    const int is_exact = pair->place_count == 0;
    points->pair = pair;
    points->couple = is_exact ? haptable_pair_couple_exact : haptable_pair_couple_clusters;
    points->pull = is_exact ? haptable_pair_pull_exact : haptable_pair_pull_clusters;
    points->settle = pair->model->energy || pair->model->frictionless ? haptable_points_settle : 0;
}
