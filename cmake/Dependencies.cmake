# planegraph_find_package(NAME ...): find_package(NAME ... REQUIRED) for what our libraries link. The installed package
# looks for the same again on behalf of its users.
macro(planegraph_find_package)
  find_package(${ARGN} REQUIRED)
  string(REPLACE ";" " " package "${ARGN}")
  set_property(GLOBAL APPEND PROPERTY PLANEGRAPH_PACKAGES "${package}")
endmacro()

# Packages of the core. PCL, GTest and Benchmark are looked for where they are used.
planegraph_find_package(Threads)
planegraph_find_package(Eigen3 3.4 NO_MODULE)
planegraph_find_package(Ceres 2.1)
planegraph_find_package(nlohmann_json 3.11)
planegraph_find_package(yaml-cpp)
planegraph_find_package(nanoflann)
planegraph_find_package(embree 3)
planegraph_find_package(ZLIB)
planegraph_find_package(GeographicLib)
planegraph_find_package(LibExif)
planegraph_find_package(Cholmod)
# Packages of the command line tool alone.
find_package(glog REQUIRED)
find_package(gflags REQUIRED)
# planegraph_find_pcl(): what of PCL the triangulation links, quietly, where it is installed. (The component `surface` brings
# VTK, whose package asks for MPI; the triangulation itself is a template.) Our libraries are static, so the users of the
# installed package need it, too.
macro(planegraph_find_pcl)
  find_package(PCL 1.12 QUIET COMPONENTS common kdtree search)
  if(TARGET pcl_search)
    set_property(GLOBAL APPEND PROPERTY PLANEGRAPH_PACKAGES "PCL COMPONENTS common kdtree search")
  else()
    message(STATUS "PCL not found: no area by greedy projection triangulation")
  endif()
endmacro()
