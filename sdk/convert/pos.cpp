// SPDX-License-Identifier: Apache-2.0
// Solution files of RTKLIB: manual of ver. 2.4.2, appendix B.1; solution.c of 2.4.3 for the columns of velocity.
#include <cmath>

#include "binnacle/geodesy.hpp"
#include "format.hpp"
#include "text.hpp"

namespace binnacle::convert {

namespace {

constexpr const char* flags = "Q=1:fix,2:float,3:sbas,4:dgps,5:single,6:ppp,ns=# of satellites";

class PosText {
 public:
  explicit PosText(const Material& material)
      : material_(material),
        is_ecef_(material.track.kind == PositionKind::ecef),
        has_velocity_(material.track.has_velocity && material.track.is_velocity_ecef == is_ecef_),
        decimals_(decimals_of(material.track.records)) {}

  std::string text() {
    head();
    for (const Record& record : material_.track.records) line(record);
    return std::move(text_);
  }

 private:
  void head() {
    const auto& provenance = material_.run.provenance;
    const auto version = provenance.find("version");
    text_ += "% program   : Binnacle" +
             (version != provenance.end() && version->is_string() ? " " + version->get<std::string>() : "") + "\n";
    text_ += "% filter    : " + one_line(material_.track.filter) +
             ", Q and ns are no figures of it; covariances between axes: 0\n%\n";
    text_ += is_ecef_ ? "% (x/y/z-ecef=WGS84," : "% (lat/lon/height=WGS84/ellipsoidal,";
    text_ += std::string(flags) + ")\n%  GPST                ";
    text_ +=
        is_ecef_
            ? " x-ecef(m) y-ecef(m) z-ecef(m) Q ns sdx(m) sdy(m) sdz(m) sdxy(m) sdyz(m) sdzx(m) age(s) ratio"
            : " latitude(deg) longitude(deg) height(m) Q ns sdn(m) sde(m) sdu(m) sdne(m) sdeu(m) sdun(m) age(s) ratio";
    if (has_velocity_)
      text_ += is_ecef_ ? " vx(m/s) vy(m/s) vz(m/s) sdvx sdvy sdvz sdvxy sdvyz sdvzx"
                        : " vn(m/s) ve(m/s) vu(m/s) sdvn sdve sdvu sdvne sdveu sdvun";
    text_ += '\n';
  }

  static std::string one_line(std::string text) {
    for (char& c : text)
      if (c == '\n' || c == '\r') c = ' ';
    return text;
  }

  void number(double value, int width, int decimals) {
    std::string digits;
    append_fixed(digits, std::isfinite(value) ? value : 0, decimals);
    const auto wide = static_cast<std::size_t>(width);
    text_ += std::string(1 + (digits.size() < wide ? wide - digits.size() : 0), ' ') + digits;
  }

  /// 11 22 33, and 0 for what is between them: a run's results have no covariances.
  void sigmas(const double (&sigma)[3], int width, int decimals) {
    for (const double each : sigma) number(each, width, decimals);
    for (int i = 0; i < 3; ++i) number(0, width, decimals);
  }

  void line(const Record& record) {
    const Time gps = material_.time->clock.gps(record.t);
    text_ += calendar(gps + civil_time::begin_of(civil_time::gps_epoch), decimals_, '/', ' ');
    if (is_ecef_) {
      for (const double each : record.ecef) number(each, 14, 4);
    } else {
      number(degrees(record.lat), 14, 9);
      number(degrees(record.lon), 14, 9);
      number(record.height, 10, 4);
    }
    text_ += "   5   0";
    sigmas(record.sigma, 8, 4);
    number(0, 6, 2);
    number(0, 6, 1);
    if (has_velocity_) velocity(record);
    text_ += '\n';
  }

  void velocity(const Record& record) {
    Eigen::Vector3d v(record.velocity[0], record.velocity[1], -record.velocity[2]);
    if (is_ecef_)
      v = geodesy::C_en(record.lat, record.lon) *
          Eigen::Vector3d(record.velocity[0], record.velocity[1], record.velocity[2]);
    for (const double each : v) number(each, 10, 5);
    sigmas(record.velocity_sigma, 8, 5);
  }

  const Material& material_;
  bool is_ecef_, has_velocity_;
  int decimals_;
  std::string text_;
};

}  // namespace

std::string pos(const Material& material) { return PosText(material).text(); }

}  // namespace binnacle::convert
