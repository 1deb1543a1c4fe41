// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Replaces OpenCV's windows on machines without display: shows nothing, and waits for no key.

#include <opencv2/highgui.hpp>

namespace cv
{

void namedWindow(const String&, int)
{
}
void imshow(const String&, InputArray)
{
}
void setMouseCallback(const String&, MouseCallback, void*)
{
}
void destroyAllWindows()
{
}
int waitKey(int)
{
    return -1;
}

}  // namespace cv
