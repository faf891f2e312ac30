// Prints as JSON what libsdformat resolves in SDF files: the poses, axes, limits and ties of a model's links, joints and frames.
//
//   g++ -std=c++17 judge.cpp -o judge $(pkg-config --cflags --libs sdformat12) && ./judge *.sdf > judged.json
//
// All poses are in the frame of the world, or of the file where it has a model alone, as rows of a 4x4 matrix.

#include <cmath>
#include <cstdio>
#include <iostream>
#include <sstream>
#include <string>
#include <vector>

#include <sdf/sdf.hh>

using Pose = ignition::math::Pose3d;

static std::string Number(double x) {
  char text[40];
  std::snprintf(text, sizeof text, "%.17g", x);
  return std::isinf(x) ? (x > 0 ? "1e999" : "-1e999") : text;
}

static std::string Matrix(const Pose &pose) {
  ignition::math::Matrix4d T(pose);
  std::string text = "[";
  for (int i = 0; i < 4; ++i) {
    for (int k = 0; k < 4; ++k) text += (k ? ", " : i ? ", [" : "[") + Number(T(i, k));
    text += "]";
  }
  return text + "]";
}

static void Check(const sdf::Errors &errors) {
  for (const auto &error : errors) throw std::runtime_error(error.Message());
}

struct Printer {
  std::vector<std::string> links, joints, frames, shapes;

  template <typename T>
  Pose Resolved(const T &item, const std::string &to = "") {
    Pose pose;
    Check(item.SemanticPose().Resolve(pose, to));
    return pose;
  }

  static std::string Entry(const std::string &name, const std::string &rest) { return "\"" + name + "\": " + rest; }

  void Model(const sdf::Model &model, const Pose &outer, const std::string &scope) {
    for (uint64_t k = 0; k < model.LinkCount(); ++k) {
      const auto &link = *model.LinkByIndex(k);
      Pose T = outer * Resolved(link, "__model__");
      links.push_back(Entry(scope + link.Name(), Matrix(T)));
      for (uint64_t n = 0; n < link.CollisionCount(); ++n) {
        const auto &shape = *link.CollisionByIndex(n);
        shapes.push_back(Entry(scope + link.Name() + "/" + shape.Name(), Matrix(Resolved(shape, link.Name()))));
      }
      for (uint64_t n = 0; n < link.VisualCount(); ++n) {
        const auto &shape = *link.VisualByIndex(n);
        shapes.push_back(Entry(scope + link.Name() + "/" + shape.Name(), Matrix(Resolved(shape, link.Name()))));
      }
    }
    for (uint64_t k = 0; k < model.FrameCount(); ++k) {
      const auto &frame = *model.FrameByIndex(k);
      std::string body;
      Check(frame.ResolveAttachedToBody(body));
      frames.push_back(Entry(scope + frame.Name(), "{\"pose\": " + Matrix(outer * Resolved(frame, "__model__")) +
                                                       ", \"body\": \"" + scope + body + "\"}"));
    }
    for (uint64_t k = 0; k < model.JointCount(); ++k) {
      const auto &joint = *model.JointByIndex(k);
      std::string parent, child;
      Check(joint.ResolveParentLink(parent));
      Check(joint.ResolveChildLink(child));
      std::string text = "{\"type\": " + std::to_string(static_cast<int>(joint.Type())) + ", \"parent\": \"" +
                         (parent == "world" ? parent : scope + parent) + "\", \"child\": \"" + scope + child +
                         "\", \"pose\": " + Matrix(outer * Resolved(joint, "__model__"));
      if (const auto *axis = joint.Axis(0)) {
        ignition::math::Vector3d xyz;
        Check(axis->ResolveXyz(xyz));
        text += ", \"axis\": [" + Number(xyz.X()) + ", " + Number(xyz.Y()) + ", " + Number(xyz.Z()) + "], \"lower\": " +
                Number(axis->Lower()) + ", \"upper\": " + Number(axis->Upper()) + ", \"effort\": " + Number(axis->Effort()) +
                ", \"velocity\": " + Number(axis->MaxVelocity());
      }
      joints.push_back(Entry(scope + joint.Name(), text + "}"));
    }
    for (uint64_t k = 0; k < model.ModelCount(); ++k) {
      const auto &nested = *model.ModelByIndex(k);
      Model(nested, outer * Resolved(nested, "__model__"), scope + nested.Name() + "::");
    }
  }
};

static std::string Joined(const std::vector<std::string> &parts) {
  std::string text;
  for (const auto &part : parts) text += (text.empty() ? "" : ",\n  ") + part;
  return "{" + text + "}";
}

int main(int argc, char **argv) {
  std::cout << "{\"libsdformat\": \"" << SDF_VERSION_FULL << " (reads SDF " << SDF_VERSION << ")\"";
  for (int n = 1; n < argc; ++n) {
    std::string path = argv[n], folder = path.substr(0, path.rfind('/') + 1), name = path.substr(path.rfind('/') + 1);
    sdf::ParserConfig config;
    config.SetFindCallback([folder](const std::string &uri) {
      auto at = uri.find("://");
      return folder + (at == std::string::npos ? uri : uri.substr(at + 3));
    });
    sdf::Root root;
    std::cout << ",\n\"" << name << "\": ";
    try {
      Check(root.Load(path, config));
      const sdf::Model *model = root.Model();
      Pose outer;
      Printer printer;
      if (model == nullptr) {
        const auto &world = *root.WorldByIndex(0);
        for (uint64_t k = 0; k < world.ModelCount(); ++k)
          if (!world.ModelByIndex(k)->Static()) model = world.ModelByIndex(k);
        Check(model->SemanticPose().Resolve(outer, "world"));
      } else if (!model->PlacementFrameName().empty()) {
        Pose placed;
        Check(model->SemanticPose().Resolve(outer, "__root__"));
      } else {
        outer = model->RawPose();
      }
      printer.Model(*model, outer, "");
      std::cout << "{\"links\": " << Joined(printer.links) << ",\n \"joints\": " << Joined(printer.joints)
                << ",\n \"frames\": " << Joined(printer.frames) << ",\n \"shapes\": " << Joined(printer.shapes) << "}";
    } catch (const std::exception &error) {
      std::ostringstream quoted;
      for (char c : std::string(error.what())) quoted << (c == '"' || c == '\n' ? '\'' : c);
      std::cout << "{\"refused\": \"" << quoted.str() << "\"}";
    }
  }
  std::cout << "}\n";
}
