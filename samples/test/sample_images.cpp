// This file is part of the aqorb project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.

// Makes the images that the samples' tests use, from a photograph or a drawn scene: two views of it, three
// overlapping parts, a video of images and a fisheye lens's image.

#include "../../perf/perf_scene.hpp"

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include <cstdlib>

using namespace cv;

static void save(const String& path, const Mat& image)
{
    if (!imwrite(path, image))
        CV_Error(Error::StsError, path + ": cannot be written");
}

// What a lens that maps angles to radii sees of the scene, in a circle.
static Mat fisheye(const Mat& scene)
{
    const int side = 600;
    Mat map(side, side, CV_32FC2);
    for (int y = 0; y < side; y++)
        for (int x = 0; x < side; x++)
        {
            const double dx = (x - side / 2) / (side / 2. - 4), dy = (y - side / 2) / (side / 2. - 4);
            const double r = std::sqrt(dx * dx + dy * dy);
            const double stretch = r < 1 ? std::tan(1.2 * r) / std::max(r, 1e-6) / std::tan(1.2) : 1e6;
            map.at<Vec2f>(y, x) =
                Vec2f(float(scene.cols / 2 * (1 + dx * stretch)), float(scene.rows / 2 * (1 + dy * stretch)));
        }
    Mat image;
    remap(scene, image, map, noArray(), INTER_LINEAR, BORDER_CONSTANT);
    return image;
}

static Mat photographOrScene()
{
    const char* const data = std::getenv("OPENCV_TEST_DATA_PATH");
    const String leuven = "/cv/detectors_descriptors_evaluation/images_datasets/leuven/img1.png";
    const Mat photograph = data ? imread(data + leuven, IMREAD_GRAYSCALE) : Mat();
    return photograph.empty() ? opencv_test::makeStreetScene(Size(900, 600)) : photograph;
}

int main(int argc, char** argv)
{
    CV_Assert(argc == 2);
    const String folder = argv[1] + String("/");
    const Mat scene = photographOrScene();

    save(folder + "view1.png", scene);
    const Matx33d homography(0.9, -0.15, 90, 0.1, 0.95, -20, 1e-4, 5e-5, 1);
    Mat view;
    warpPerspective(scene, view, homography, scene.size());
    save(folder + "view2.png", view);

    for (int i = 0; i < 3; i++)
        save(folder + format("part%d.png", i + 1), scene(Rect(225 * i, 0, 450, 600)));
    for (int i = 0; i < 4; i++)
        save(folder + format("frame_%02d.png", i), scene(Rect(20 * i, 10 * i, 640, 480)));
    save(folder + "fisheye.png", fisheye(scene));
    return 0;
}
