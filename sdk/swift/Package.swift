// swift-tools-version:5.7
// SPDX-License-Identifier: Apache-2.0
import PackageDescription

let package = Package(
    name: "Im2fit",
    products: [.library(name: "Im2fit", targets: ["Im2fit"])],
    targets: [
        .systemLibrary(name: "CIm2fit", pkgConfig: "im2fit"),
        .target(name: "Im2fit", dependencies: ["CIm2fit"]),
    ]
)
