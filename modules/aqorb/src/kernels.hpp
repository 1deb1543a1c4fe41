// This file is part of the aqorb project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.

#ifndef OPENCV_AQORB_KERNELS_HPP
#define OPENCV_AQORB_KERNELS_HPP

#include "stages.hpp"

// What passes between a stage and its kernels (*.simd.hpp): raw pointers and plain structs only, as a file
// compiled for one CPU must not emit functions that the linker may choose for all.

namespace cv
{
namespace aqorb
{
namespace stages
{

//! Where neighbouring pixels of a resized row come from: pixel i is a + (b - a) * weight / 256.
struct ResizeBlock
{
    enum
    {
        GROUP = 8,  //!< pixels that come from the same source bytes
        GROUPS = 4,
        PIXELS = 32,
        BYTES = 16  //!< source bytes of a group
    };
    int base[GROUPS];  //!< of the groups' source bytes
    signed char a[GROUPS][2 * GROUP],
        b[GROUPS][2 * GROUP];  //!< for each pixel its source byte, then -128 (a zero)
    short weight[PIXELS];
};

//! Resizes rows by INTER_LINEAR_EXACT.
struct Resize
{
    const uchar* source;
    ptrdiff_t sourceStep;
    uchar* destination;
    ptrdiff_t destinationStep;
    int width;                  //!< of the destination
    const ResizeBlock* blocks;  //!< enough for the width
    const int *upper, *lower;   //!< by destination row: the two source rows
    const short* lowerWeight;   //!< by destination row, in 1/256
    short* rows[2];             //!< scratch, as many elements as the blocks have pixels
};

//! Neighbouring pixels of a row that are scored together.
struct ScanBlock
{
    int x;          //!< the first
    uint64 wanted;  //!< bit i: whether a corner at x + i is wanted
};

//! A scan of rows for FAST corners; a row is suppressed once the one below it has scores.
struct FastScan
{
    const uchar* image;
    ptrdiff_t step;
    const uchar* mask;  //!< of usable pixels; 0: all are
    ptrdiff_t maskStep;
    int threshold;                //!< of all corners
    int strongThreshold;          //!< >= threshold
    int top, bottom;              //!< rows in which corners are wanted
    int scoredTop, scoredBottom;  //!< rows that get scores: also the ones around, where they have a circle
    int left, right;              //!< columns that have a circle
    int y;                        //!< the next row to get scores; finished when beyond bottom
    const ScanBlock* blocks;      //!< from left to right
    int blockCount;
    int blockWidth;  //!< one of scanWidths
    uchar*
        scores;  //!< of SCAN_ROWS rows, by row modulo their number, by column; SCAN_MARGIN readable on both sides
    ptrdiff_t scoreStep;
    int* listed[2];  //!< by row modulo 2: the blocks in which there are scores
    int listedCount[2];
    uchar*
        plane;  //!< the scores of corners, from row top on, by column; off the wanted ones unknown until dropped
    ptrdiff_t planeStep;
    uint64*
        strong;  //!< by block: the columns in which a strong corner was found; unknown off the wanted ones
    CornerBlock* found;  //!< room for all blocks of the rows to scan, and two
    int foundCount;
};

const int SCAN_ROWS = 4;  // a power of two that holds three
const int SCAN_WIDTHS = 3;
const int SCAN_ALIGNMENT = 64;  // of scores, so that as few vectors as may be lie across cache lines
const int SCAN_MARGIN = 64;     // around the scores of a row, for the vectors

//! The 256 tests of a descriptor with WTA_K 2: the bit is 1 where point 0 is darker than point 1.
struct PairTests
{
    enum
    {
        COUNT = 256
    };
    float x[2][COUNT], y[2][COUNT];  //!< [point of the pair][test]
};

const int SUPPRESS_RADIUS = 3;   // of the suppression of corners, for which its kernel is written
const int SUPPRESS_MARGIN = 16;  // columns around a region that are readable in its plane of scores

//! What the pixels of a circular patch count for its moments: u and v inside, 0 outside.
struct PatchWeights
{
    enum
    {
        MAX_RADIUS = 31,
        MAX_WIDTH = 64
    };
    int radius;
    int width;  //!< of the patch, filled up with zeros for whole vectors
    short u[MAX_RADIUS + 1][MAX_WIDTH], v[MAX_RADIUS + 1][MAX_WIDTH];  //!< [|v|][u + radius]
};

}  // namespace stages
}  // namespace aqorb
}  // namespace cv

#endif
