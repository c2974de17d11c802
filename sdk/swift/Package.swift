// swift-tools-version:5.7
// SPDX-License-Identifier: Apache-2.0
import Foundation
import PackageDescription

// For apps: the framework of scripts/xcframework, once it lies here. Else the installed library, by pkg-config.
let hasFramework = FileManager.default.fileExists(atPath: Context.packageDirectory + "/CIm2fit.xcframework")
let library: Target = hasFramework
    ? .binaryTarget(name: "CIm2fit", path: "CIm2fit.xcframework")
    : .systemLibrary(name: "CIm2fit", pkgConfig: "im2fit")

let package = Package(
    name: "Im2fit",
    platforms: [.iOS(.v14), .macOS(.v12)],
    products: [.library(name: "Im2fit", targets: ["Im2fit"])],
    targets: [
        library,
        .target(name: "Im2fit", dependencies: ["CIm2fit"]),
    ]
)
