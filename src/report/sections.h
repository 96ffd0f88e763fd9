#pragma once

#include <string>

#include "report/report_data.h"

namespace planegraph {

// The parts of the report that are text and tables. Each is HTML; empty where nothing is known.

/// Title, verdict in one sentence and the figures at a glance.
std::string HeaderHtml(const ReportData& data);
/// The directions that the planes leave open, in words, and the run's warnings.
std::string OpenDirectionsHtml(const ReportData& data);
std::string ScansHtml(const ReportData& data);
std::string RegistrationsHtml(const ReportData& data);
/// Registrations and measurements that take no part, and why.
std::string SwitchedOffHtml(const ReportData& data);
std::string MapsHtml(const ReportData& data);
std::string EvaluationHtml(const ReportData& data);
/// How the errors against the reference compare with the covariances.
std::string ConsistencyHtml(const ReportData& data);
std::string SolveHtml(const ReportData& data);
std::string TimesHtml(const ReportData& data);
/// Flags and everything else under `configuration`, and the version stamp.
std::string ConfigurationHtml(const ReportData& data);

}  // namespace planegraph
