// SPDX-License-Identifier: Apache-2.0
// A sample: models from an app's assets. Copy it into an app. The tests compile it with stubs of Android's classes.
package im2fit.sample

import android.content.res.AssetManager
import im2fit.sdk.ModelFile
import im2fit.sdk.Models

/**
 * Opens something with the pack [name] of the app's assets, which is stored without compression
 * (`androidResources { noCompress += "i2p" }`), where it lies in the APK:
 * `Models.ofAssets(assets, "im2fit-models.i2p") { FitSession(camera, it) }`.
 *
 * @param open called once. The models hold only while it runs
 */
inline fun <T> Models.Companion.ofAssets(assets: AssetManager, name: String, open: (Models) -> T): T =
    assets.openFd(name).use {
        open(Models.ofPack(ModelFile.Descriptor(it.parcelFileDescriptor.fd, it.startOffset, it.length)))
    }
