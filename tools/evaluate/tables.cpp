// This file is part of the aqorb project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.

#include "results.hpp"

#include <fstream>
#include <limits>
#include <sstream>

namespace
{

const char* const PAPER_SETS[] = {"bikes", "leuven", "bark", "trees", "ubc"};
const int IMAGES = 6;

//! What a set's images were made worse by; empty: nothing.
std::string degradationOf(const std::string& set)
{
    return set.substr(std::min(set.find('/'), set.size() - 1) + 1);
}

//! Mean of a value over those rows that are asked for; not a number where there are none.
template <typename Rows, typename Which, typename Value>
double mean(const Rows& rows, Which which, Value value)
{
    double sum = 0;
    int count = 0;
    for (const auto& row : rows)
    {
        if (!which(row))
            continue;
        sum += value(row);
        count++;
    }
    return count ? sum / count : std::numeric_limits<double>::quiet_NaN();
}

std::string cell(double value, const char* format = "%.2f")
{
    return cvIsNaN(value) ? "" : cv::format(format, value);
}

double uniformityOf(const FeatureRow& row)
{
    return row.uniformity;
}

double timeOf(const FeatureRow& row)
{
    return row.milliseconds < 0 ? std::numeric_limits<double>::quiet_NaN() : row.milliseconds;
}

//! The paper's numbers, by table,set,image,method,quantity.
std::map<std::string, double> readPaper()
{
    std::ifstream file(AQORB_PAPER_TABLES);
    std::map<std::string, double> values;
    for (std::string line; std::getline(file, line);)
    {
        const size_t comma = line.rfind(',');
        values[line.substr(0, comma)] = std::atof(line.substr(comma + 1).c_str());
    }
    if (values.empty())
        CV_Error(cv::Error::StsObjectNotFound, std::string(AQORB_PAPER_TABLES) + ": cannot be read");
    return values;
}

class Tables
{
public:
    Tables(const Results& results_, std::ostream& out_)
        : results(results_), out(out_), paper(readPaper()), n0(results_.numbers[0])
    {
    }

    void write()
    {
        out << "Written by aqorb_evaluate with OpenCV " << CV_VERSION << ", " << cv::getCPUFeaturesLine()
            << ".\n";
        for (const auto& absent : results.absent)
            out << "Absent: " << absent.first << " (" << absent.second << ").\n";
        threeMethods("1", "bikes");
        threeMethods("2", "leuven");
        fiveMethods();
        meansBySet();
        claims();
        for (const std::string degradation : {"", "dark", "gamma", "noise"})
            beyond(degradation);
        distinctBySet();
        ablation();
        odometry();
    }

private:
    double printed(const std::string& table, const std::string& set, int image, const std::string& method,
                   const char* quantity) const
    {
        const auto found =
            paper.find(table + "," + set + "," + std::to_string(image) + "," + method + "," + quantity);
        return found == paper.end() ? std::numeric_limits<double>::quiet_NaN() : found->second;
    }

    //! Mean over the images of a plain set, or one of them, at the paper's number of features.
    template <typename Value>
    double ours(const std::string& set, int image, const std::string& method, Value value) const
    {
        return mean(
            results.features,
            [&](const FeatureRow& row) {
                return row.set == set && (image == 0 || row.image == image) && row.method == method &&
                       row.n == n0;
            },
            value);
    }

    //! Mean over the paper's five sets.
    template <typename Value> double oursOfAll(const std::string& method, Value value) const
    {
        double sum = 0;
        for (const char* set : PAPER_SETS)
            sum += ours(set, 0, method, value) / 5;
        return sum;
    }

    template <typename Value>
    double matching(const std::string& set, const std::string& degradation, const std::string& method, int n,
                    Value value) const
    {
        return mean(
            results.matching,
            [&](const MatchingRow& row)
            {
                return (set.empty() ? degradationOf(row.set) == degradation : row.set == set) &&
                       row.method == method && (n == 0 || row.n == n);
            },
            [&](const MatchingRow& row) { return double(value(row.matching)); });
    }

    double areaUnderCurveOf(const std::string& degradation, const std::string& method, int n,
                            double limit) const
    {
        return matching("", degradation, method, n,
                        [&](const Matching& m) { return areaUnderCurve(m.errors, limit); });
    }

    void head(const std::string& title, const std::string& columns)
    {
        out << "\n## " << title << "\n\n" << columns << "\n";
        out << "|---|";
        for (size_t i = 2; i < size_t(std::count(columns.begin(), columns.end(), '|')); i++)
            out << "---:|";
        out << "\n";
    }

    //! Tables 1 and 2: A, B and C by image.
    void threeMethods(const char* table, const char* set)
    {
        const char* const methods[] = {"orb", "orb_slam", "paper", "aqorb"};
        const std::string columns =
            "| image | A paper | A here | B paper | B here | C paper | C here | as shipped |";
        for (const char* quantity : {"uniformity", "time_ms"})
        {
            const bool isTime = quantity != std::string("uniformity");
            head(cv::format("Table %s (%s): %s", table, set, isTime ? "CPU time in ms" : "uniformity"),
                 columns);
            for (int image = 1; image <= IMAGES; image++)
            {
                out << "| " << image << " |";
                for (const char* method : methods)
                {
                    if (method != std::string("aqorb"))
                        out << ' ' << cell(printed(table, set, image, method, quantity)) << " |";
                    out << ' ' << cell(ours(set, image, method, isTime ? timeOf : uniformityOf)) << " |";
                }
                out << '\n';
            }
        }
    }

    //! Table 3: methods by image and set, the paper's rows above ours.
    void fiveMethods()
    {
        head("Table 3: uniformity", "| set, method | img1 | img2 | img3 | img4 | img5 | img6 | mean |");
        for (const char* set : PAPER_SETS)
        {
            for (const std::string& method : results.methods)
            {
                row(std::string(set) + ", " + results.titles.at(method) + ", paper",
                    [&](int image) { return printed("3", set, image, method, "uniformity"); });
                row(std::string(set) + ", " + results.titles.at(method) + ", here",
                    [&](int image) { return ours(set, image, method, uniformityOf); });
            }
        }
    }

    template <typename Value> void row(const std::string& label, Value value)
    {
        double sum = 0;
        std::ostringstream cells;
        for (int image = 1; image <= IMAGES; image++)
        {
            sum += value(image) / IMAGES;
            cells << ' ' << cell(value(image)) << " |";
        }
        if (!cvIsNaN(sum))
            out << "| " << label << " |" << cells.str() << ' ' << cell(sum) << " |\n";
    }

    //! Figures 6 to 8 in numbers.
    void meansBySet()
    {
        const std::string columns = "| method | bikes | leuven | bark | trees | ubc | mean |";
        const auto table = [&](const char* title, const char* format, double (*value)(const FeatureRow&))
        {
            head(title, columns);
            for (const std::string& method : results.methods)
            {
                out << "| " << results.titles.at(method) << " |";
                for (const char* set : PAPER_SETS)
                    out << ' ' << cell(ours(set, 0, method, value), format) << " |";
                out << ' ' << cell(oursOfAll(method, value), format) << " |\n";
            }
        };
        table("Uniformity by set", "%.2f", uniformityOf);
        table("Occupied share of a 16x12 grid by set", "%.3f",
              [](const FeatureRow& r) { return r.occupancy; });
        table("CPU time in ms by set", "%.2f", timeOf);

        head("Times of C", columns);
        out << "| less than B, %, paper |";
        for (const char* set : PAPER_SETS)
            out << ' '
                << cell(paper.at(std::string("text,") + set + ",mean,paper,percent_less_time_than_orb_slam"))
                << " |";
        out << " |\n";
        const auto ratios =
            [&](const char* title, const char* method, double (*ratio)(double other, double c))
        {
            out << "| " << title << " |";
            for (const char* set : PAPER_SETS)
                out << ' ' << cell(ratio(ours(set, 0, method, timeOf), ours(set, 0, "paper", timeOf)))
                    << " |";
            out << ' ' << cell(ratio(oursOfAll(method, timeOf), oursOfAll("paper", timeOf))) << " |\n";
        };
        ratios("less than B, %, here", "orb_slam", [](double b, double c) { return 100 * (1 - c / b); });
        ratios("B over C", "orb_slam", [](double b, double c) { return b / c; });
        ratios("A over C", "orb", [](double a, double c) { return a / c; });
    }

    void claim(const std::string& what, const std::string& asked, const std::string& here, bool holds)
    {
        out << "| " << what << " | " << asked << " | " << here << " | " << (holds ? "yes" : "no") << " |\n";
    }

    //! How many of the paper's values of a method are met within 0.3, of those in the tables given.
    int met(const char* table, const char* set, const char* method, int firstImage, int lastImage) const
    {
        int count = 0;
        for (int image = firstImage; image <= lastImage; image++)
            count += std::abs(printed(table, set, image, method, "uniformity") -
                              ours(set, image, method, uniformityOf)) <= 0.3 + 1e-9;
        return count;
    }

    //! Of the difference of two methods' areas under the curve, as it varies between pairs of images.
    double standardError(const std::string& a, const std::string& b, double limit) const
    {
        std::map<std::pair<std::string, int>, double> differences;
        for (const MatchingRow& row : results.matching)
        {
            if (!degradationOf(row.set).empty() || (row.method != a && row.method != b))
                continue;
            const double area = areaUnderCurve(row.matching.errors, limit) / double(results.numbers.size());
            differences[std::make_pair(row.set, row.image)] += row.method == a ? area : -area;
        }
        double sum = 0, squares = 0;
        for (const auto& difference : differences)
        {
            sum += difference.second;
            squares += difference.second * difference.second;
        }
        const double n = double(differences.size());
        return std::sqrt((squares - sum * sum / n) / (n - 1) / n);
    }

    //! What is claimed, and whether it holds in this run.
    void claims()
    {
        for (const char* method : {"orb", "orb_slam", "paper", "aqorb", "sift"})
            if (cvIsNaN(oursOfAll(method, uniformityOf)))
                return;  // not everything that is needed was measured
        head("What is claimed", "| | asked | here | holds |");
        const int a = met("1", "bikes", "orb", 1, 4) + met("2", "leuven", "orb", 1, IMAGES);
        claim("column A within 0.3 of the paper: bikes 1 to 4, leuven", "10 of 10",
              std::to_string(a) + " of 10", a == 10);
        int sift = 0;
        for (const char* set : PAPER_SETS)
            sift += met("3", set, "sift", 1, IMAGES);
        claim("SIFT within 0.3 of the paper", "20 of 30", std::to_string(sift) + " of 30", sift >= 20);

        const double shipped = oursOfAll("aqorb", uniformityOf), asPaper = oursOfAll("paper", uniformityOf),
                     b = oursOfAll("orb_slam", uniformityOf);
        claim("uniformity as shipped, mean of five sets", "at most 154", cell(shipped), shipped <= 154);
        claim("the same below B's", "by at least 8", cell(b - shipped), b - shipped >= 8);
        int below = 0, belowClassical = 0;
        for (const char* set : PAPER_SETS)
        {
            const double u = ours(set, 0, "aqorb", uniformityOf);
            below += u < ours(set, 0, "orb_slam", uniformityOf);
            bool all = true;
            for (const char* method : {"sift", "surf", "brisk"})
                all = all && !(u >= ours(set, 0, method, uniformityOf));  // one that is absent does not count
            belowClassical += all;
        }
        claim("sets on which as shipped is below B", "at least 4", std::to_string(below), below >= 4);
        claim("sets on which it is below SIFT, SURF and BRISK", "5", std::to_string(belowClassical),
              belowClassical == 5);
        claim("uniformity with the paper's settings", "at most B's " + cell(b), cell(asPaper), asPaper <= b);

        const auto distinct = [&](const char* method)
        { return matching("", "", method, 0, [](const Matching& m) { return m.distinct; }); };
        for (const char* other : {"orb", "orb_slam"})
        {
            const double percent = 100 * (distinct("aqorb") / distinct(other) - 1);
            claim("distinct correct matches above " + results.titles.at(other) + ", mean over n and sets",
                  "by 15 %", cell(percent, "%.1f %%"), percent >= 15);
        }
        const double auc = areaUnderCurveOf("", "aqorb", 0, 5), aucB = areaUnderCurveOf("", "orb_slam", 0, 5);
        claim("homography AUC@5, mean over n and sets", "at least B's " + cell(aucB, "%.3f"),
              cell(auc, "%.3f") +
                  cell(standardError("aqorb", "orb_slam", 5), " (standard error of the difference %.3f)"),
              auc >= aucB);

        const double times[] = {oursOfAll("orb", timeOf), oursOfAll("orb_slam", timeOf),
                                oursOfAll("paper", timeOf)};
        claim("time of A over time of C, mean of five sets", "above 1", cell(times[0] / times[2]),
              times[2] < times[0]);
        claim("time of B over time of C", "at least 5", cell(times[1] / times[2]), times[1] >= 5 * times[2]);
    }

    void qualityRow(const std::string& degradation, const std::string& method, const std::string& title,
                    int n)
    {
        const auto which = [&](const FeatureRow& row)
        { return degradationOf(row.set) == degradation && row.method == method && row.n == n; };
        const auto keypoints = [](const FeatureRow& row) { return row.keypoints; };
        out << "| " << title << " | " << n << " | " << cell(mean(results.features, which, keypoints), "%.0f")
            << " | " << cell(mean(results.features, which, uniformityOf), "%.1f") << " | "
            << cell(mean(results.features, which, [](const FeatureRow& r) { return r.occupancy; }), "%.3f");
        const auto add = [&](const char* format, double (*value)(const Matching&))
        { out << " | " << cell(matching("", degradation, method, n, value), format); };
        add("%.1f", [](const Matching& m) { return double(m.distinct); });
        add("%.1f", [](const Matching& m) { return double(m.places); });
        add("%.3f", [](const Matching& m) { return m.precision(); });
        add("%.3f", [](const Matching& m) { return m.repeatability; });
        for (const double limit : {3., 5., 10.})
            out << " | " << cell(areaUnderCurveOf(degradation, method, n, limit), "%.3f");
        out << " |\n";
    }

    const char* const QUALITY = "| method | n | keypoints | u | occupancy | distinct | places | precision | "
                                "repeatability | AUC@3 | AUC@5 | AUC@10 |";

    void beyond(const std::string& degradation)
    {
        const auto isOf = [&](const FeatureRow& row) { return degradationOf(row.set) == degradation; };
        if (std::none_of(results.features.begin(), results.features.end(), isOf))
            return;
        head("Means over all sets" + (degradation.empty() ? "" : ", " + degradation), QUALITY);
        for (const int n : results.numbers)
            for (const std::string& method : results.methods)
                qualityRow(degradation, method, results.titles.at(method), n);
    }

    void distinctBySet()
    {
        std::vector<std::string> sets;
        for (const MatchingRow& row : results.matching)
            if (degradationOf(row.set).empty() && (sets.empty() || sets.back() != row.set))
                sets.push_back(row.set);
        std::string columns = "| method |";
        for (const std::string& set : sets)
            columns += " " + set + " |";
        head("Distinct correct matches by set, mean over n", columns);
        for (const std::string& method : results.methods)
        {
            out << "| " << results.titles.at(method) << " |";
            for (const std::string& set : sets)
                out << ' '
                    << cell(matching(set, "", method, 0, [](const Matching& m) { return m.distinct; }),
                            "%.1f")
                    << " |";
            out << '\n';
        }
    }

    void ablation()
    {
        if (results.ablations.empty())
            return;
        head("Ablation: as shipped but for", QUALITY);
        for (const int n : results.numbers)
            for (const Ablation& ablation : results.ablations)
                qualityRow("", ablation.name, ablation.but, n);
    }

    void odometry()
    {
        if (results.odometry.empty())
            return;
        head("Stereo odometry, from frame to frame",
             "| method | n | stereo points | matches | inliers | translation error, cm, "
             "RMS | rotation error, degrees, RMS | frames without motion |");
        for (const int n : results.numbers)
        {
            for (const std::string& method : results.methods)
            {
                const auto is = [&](const OdometryRow& r) { return r.method == method && r.n == n; };
                const auto found = [&](const OdometryRow& r) { return is(r) && r.metres < NO_MOTION; };
                const auto average = [&](double (*value)(const OdometryRow&))
                { return mean(results.odometry, is, value); };
                const auto rms = [&](double (*square)(const OdometryRow&))
                { return std::sqrt(mean(results.odometry, found, square)); };
                out << "| " << results.titles.at(method) << " | " << n << " | "
                    << cell(average([](const OdometryRow& r) { return double(r.stereo); }), "%.0f") << " | "
                    << cell(average([](const OdometryRow& r) { return double(r.matches); }), "%.0f") << " | "
                    << cell(average([](const OdometryRow& r) { return double(r.inliers); }), "%.0f") << " | "
                    << cell(100 * rms([](const OdometryRow& r) { return r.metres * r.metres; })) << " | "
                    << cell(rms([](const OdometryRow& r) { return r.degrees * r.degrees; }), "%.4f") << " | "
                    << std::count_if(results.odometry.begin(), results.odometry.end(),
                                     [&](const OdometryRow& r) { return is(r) && !found(r); })
                    << " |\n";
            }
        }
    }

    const Results& results;
    std::ostream& out;
    const std::map<std::string, double> paper;
    const int n0;  // the paper's number of features
};

}  // namespace

void writeTables(const Results& results, const std::string& file)
{
    std::ofstream out(file);
    Tables(results, out).write();
    if (!out)
        CV_Error(cv::Error::StsError, file + ": cannot be written");
}
