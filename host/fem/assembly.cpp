// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/fem/assembly.hpp"

#include <algorithm>

namespace haptable {

namespace {

/// The lists with each node's place among the unknowns, or -1.
Lists places_of(const Lists& nodes, std::span<const std::int32_t> unknown) {
    Lists places;
    std::vector<std::int32_t> list;
    for (std::size_t i = 0; i < nodes.size(); ++i) {
        list.clear();
        for (std::int32_t node : nodes[i]) list.push_back(unknown[static_cast<std::size_t>(node)]);
        places.append(list);
    }
    return places;
}

/// K with its pattern from the graph of the unknowns and all values 0.
Eigen::SparseMatrix<double> empty_matrix(const Lists& neighbours) {
    const Eigen::Index size = 3 * static_cast<Eigen::Index>(neighbours.size());
    Eigen::SparseMatrix<double> k(size, size);
    k.resizeNonZeros(9 * static_cast<Eigen::Index>(neighbours.items()));
    std::fill_n(k.valuePtr(), k.data().size(), 0.0);
    int* begin = k.outerIndexPtr();
    int next = 0;
    for (std::size_t a = 0; a < neighbours.size(); ++a)
        for (int column = 0; column < 3; ++column) {
            *begin++ = next;
            for (std::int32_t b : neighbours[a])
                for (int row = 0; row < 3; ++row) k.innerIndexPtr()[next++] = 3 * b + row;
        }
    *begin = next;
    return k;
}

/// place: of the matrix' nodes among the unknowns; -1: that node has no rows in K.
void add(std::span<const std::int32_t> place, const Eigen::MatrixXd& matrix, const Lists& neighbours,
         Eigen::SparseMatrix<double>& k) {
    for (std::size_t b = 0; b < place.size(); ++b) {
        if (place[b] < 0) continue;
        const std::span<const std::int32_t> rows = neighbours[static_cast<std::size_t>(place[b])];
        const int* begin = k.outerIndexPtr() + 3 * static_cast<std::ptrdiff_t>(place[b]);
        for (std::size_t a = 0; a < place.size(); ++a) {
            if (place[a] < 0) continue;
            const std::ptrdiff_t offset = 3 * (std::lower_bound(rows.begin(), rows.end(), place[a]) - rows.begin());
            const auto row = 3 * static_cast<Eigen::Index>(a), column = 3 * static_cast<Eigen::Index>(b);
            for (Eigen::Index j = 0; j < 3; ++j)
                Eigen::Map<Eigen::Vector3d>(k.valuePtr() + begin[j] + offset) += matrix.block<3, 1>(row, column + j);
        }
    }
}

}  // namespace

Eigen::SparseMatrix<double> assemble(const Lists& nodes, const FillMatrix& fill, std::span<const std::int32_t> unknown,
                                     std::int32_t unknown_count) {
    const Lists place = places_of(nodes, unknown);
    const Lists neighbours = place.neighbours(place.holders(static_cast<std::size_t>(unknown_count)));
    Eigen::SparseMatrix<double> k = empty_matrix(neighbours);
    Eigen::MatrixXd matrix;
    for (std::size_t i = 0; i < nodes.size(); ++i) {
        fill(i, matrix);
        add(place[i], matrix, neighbours, k);
    }
    return k;
}

}  // namespace haptable
