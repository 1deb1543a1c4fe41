// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Selection of keypoints from corners, declared in the order of doc/selection.md.

#ifndef OPENCV_AQORB_SELECTION_HPP
#define OPENCV_AQORB_SELECTION_HPP

#include "detector/corners.hpp"
#include "detector/index_sort.hpp"
#include "detector/harris_orientation.hpp"
#include "detector/parameters.hpp"
#include "detector/types.hpp"

namespace cv
{
namespace aqorb
{

// ---- 1. quotas --------------------------------------------------------------------------------

//! Number of features for each level, nfeatures in all: in proportion to area * scale^1.25, and half as much again for
//! the finest level.
std::vector<int> rankedQuotas(int nfeatures, const std::vector<Size>& regions,
                              const std::vector<float>& scales);

// ---- 2. tree ----------------------------------------------------------------------------------

//! Leaves of a quadtree: columns and rows of equal parts of a region.
struct LeafGrid
{
    int columns, rows;
    int columnBits;  //!< low bits of a leaf number that hold its column

    unsigned numberOf(int column, int row) const { return unsigned(column) | unsigned(row) << columnBits; }
    int columnOf(unsigned leaf) const { return int(leaf & ((1u << columnBits) - 1)); }
    int rowOf(unsigned leaf) const { return int(leaf >> columnBits); }
    //! Upper bound of the leaf numbers, exclusive.
    size_t numbers() const { return size_t(rows) << columnBits; }
};

//! Leaves of several trees in a row along the longer side of the region. Each tree has 2^depth columns and rows.
LeafGrid leafGrid(Size region, int trees, int depth);

//! Tree of the smallest depth with 9 * density usable leaves for each of `quota` points. If its leaves would be shorter
//! than 2 pixels, there are longer side / shorter side (rounded down) trees. There are at most 2^24 leaves.
//! @param usable unmasked share of the region
LeafGrid rankedGrid(Size region, double usable, int quota, double density = 1);

//! Number of the leaf at a position in a region.
inline unsigned leafOf(double x, double y, Size region, const LeafGrid& grid)
{
    return grid.numberOf(int(x * grid.columns / region.width), int(y * grid.rows / region.height));
}

// ---- 3. representatives -----------------------------------------------------------------------

//! A point to sort. Ties keep the input order.
struct LeafPoint
{
    unsigned leaf;  //!< see leafOf
    int key;        //!< greater is better: a FAST score, or the sortKey of a response
};

//! Density of the representatives by the weight: 1 up to 0.15, then in proportion. A strong corner can then have others
//! beside it, as in cv::ORB.
double representativeDensity(double strengthWeight);

/** Finds the best point of each leaf, unless at least 3 * density of the leaf's eight neighbours have better best points.
 Ties in a leaf go to the first point, and between leaves to the first leaf.
 @return indices of these points, in the order of the leaves */
std::vector<unsigned> findRepresentatives(const std::vector<LeafPoint>& points, const LeafGrid& grid,
                                          double density = 1);

// ---- 4. strength ------------------------------------------------------------------------------

//! Corners of a level with their responses: Harris responses or FAST scores.
std::vector<CornerResponse> responsesOf(const Mat& image, const std::vector<Corner>& corners, bool useHarris);
//! Patch of the moments: every third row of the default patch.
OrientationPatch patchForStrength(int patchSize);
//! Fourth powers of the strengths FAST * sqrt(sqrt(Harris)) * moment, which need no root.
std::vector<float> strengthsOf(const Mat& image, const std::vector<Corner>& corners,
                               const std::vector<CornerResponse>& responses, bool useHarris,
                               const OrientationPatch& patch);

// ---- 5. rank, 6. order ------------------------------------------------------------------------

//! Parameters of orderRepresentatives.
struct RankRule
{
    Size region;      //!< in pixels
    LeafGrid grid;    //!< leaves of the quadtree
    double usable;    //!< unmasked share of the region
    int quota;        //!< number of points to select from the region, > 0
    double radius;    //!< radius of the rank's disc, in units of sqrt(usable area / quota)
    double exponent;  //!< exponent of the strength
};

/** Orders representatives by (1 + rank) / strength^exponent. The rank is the number of stronger representatives within
 a disc of leaves. If part of the square around the disc is masked or lies outside the region, the rank is scaled up.
 @param leaves, strengths leaf and strength of each representative; ties go to the lower leaf
 @param usableLeaves by leaf: whether its centre is unmasked; empty: all are
 @return indices of representatives */
std::vector<unsigned> orderRepresentatives(const std::vector<unsigned>& leaves,
                                           const std::vector<float>& strengths, const RankRule& rule,
                                           const std::vector<uchar>& usableLeaves);

//! Region and quota of a level.
struct LevelPlan
{
    Rect region;  //!< part of the level that may have keypoints
    int quota;    //!< number of features
};

//! Orders the representatives among the corners of a level, the best first: points 2 to 6.
std::vector<CornerResponse> rankedOrder(const Parameters& parameters, const OrientationPatch& patch,
                                        const LevelPlan& plan, const Level& level,
                                        const std::vector<Corner>& corners);

// ---- the method -------------------------------------------------------------------------------

//! Differences between the values of SelectionType, beside the quotas and the order of the corners.
struct SelectionMethod
{
    bool isQuadtree;    //!< whether the quotas and the order are those of quadtree.hpp
    bool suppressNear;  //!< of CornerRules
    bool subPixel;      //!< whether positions are refined
    //! Minimum distance to keypoints of neighbouring levels, in pixels of the corner's level.
    double octaveDistance;
};
SelectionMethod selectionMethod(const Parameters& parameters);

// ---- 7. across levels, 8. when representatives run out, 9. order of output -----------------------

/** Finds corners and selects keypoints among them. From coarse to fine, each level gives its quota and the features
 that coarser levels lack; then, from fine to coarse, levels give the features still missing. Corners near a keypoint of
 another level are skipped. When these corners run out, all other corners of the lower threshold follow.
 @param patch patch of the strengths
 @return features of each level in raster order, with output keys */
std::vector<FeatureList> selectFeatures(const Parameters& parameters, const OrientationPatch& patch,
                                        Size imageSize, const std::vector<Level>& levels,
                                        const Thresholds& thresholds, int threads, CornerSpace& space);

// ---- for the kernel: plain structs only, see simd_compat.hpp ---------------------------------

//! Bit grid of leaves with a border: the kernel sets the bit of each leaf it has visited. The words of a row begin STEP
//! bits apart and hold twice as many bits, so the STEP bits from any leaf on lie in one word.
struct RankGrid
{
    enum
    {
        STEP = 32
    };
    uint64* bits;
    int columnBits;       //!< see LeafGrid
    int stride;           //!< words of a row
    int left, top;        //!< width of the border, in bits and rows
    const int* words;     //!< offsets of the disc's words from the word before its upper left word
    const uint64* masks;  //!< bits of the disc in each of these words
    int wordCount;
};

}  // namespace aqorb
}  // namespace cv

#endif
