// SPDX-License-Identifier: Apache-2.0
package kotlinx.coroutines

import kotlin.coroutines.CoroutineContext
import kotlin.coroutines.EmptyCoroutineContext

object Dispatchers {
    val Default: CoroutineContext = EmptyCoroutineContext
}
